# Rebuilds the reference: `make reference` in the folder above. All work is done in build/reference,
# where an interrupted run resumes; at the end the files of results/reference that are made here are
# replaced, and results/leaderboard.csv with its page. Delete a file of build/reference to have it made again.
SENSORLESS ?= $(abspath .venv/bin/sensorless)
PYTHON     ?= $(abspath .venv/bin/python)
OUT        ?= build/reference
WORK       ?= build/reference/work
SHIPPED    ?= results/reference

# Simulated seconds for every rule, and as many for PPO: decisions of 5 ms.
BUDGET ?= 50000
TRAIN  ?= --steps 10000000
SEEDS  ?= 1 2 3 4 5
SIZE   ?= 2000
# Of the scenarios to judge on.
SEED   ?= 11
SUITES ?= stress-1 handoff stress
GRID   ?= 41
RULES  ?= linear hysteresis gated fuzzy logistic
# Rules on the other observers: `make -f results/reference.mk rules` runs the command in each file
# again. Each is the best by stress-1 and unload, seed 777, of three searches or more: from the
# rule's own numbers with two seeds, and from the numbers that an older drive had. KEPT are of an
# older drive: better than what the searches found, and as far from a loss.
KEPT   ?= logistic-tuned logistic-flux-tuned gated-flux-tuned
OTHERS := $(filter-out $(KEPT) %-coupled-tuned,$(basename $(notdir $(wildcard $(SHIPPED)/tuned/*.json))))

TUNED := $(RULES:%=$(OUT)/tuned/%-coupled-tuned.json)
RUNS  := $(SEEDS:%=$(OUT)/seed-%/table.json)
# Eq. 25 on three drives, the rules tuned here, those tuned before on the other observers, and PPO.
JUDGED := sliding_mode flux_observer eq25 $(TUNED) logistic-tuned logistic-flux-tuned reference-flux \
          $(SEEDS:%=$(OUT)/seed-%) sensored

.PHONY: all
.DELETE_ON_ERROR:

all: $(OUT)/report/index.html
	$(PYTHON) studies/publish_reference.py $(OUT) $(SHIPPED) $(SUITES:%=--suite %)
	$(PYTHON) studies/leaderboard.py

$(OUT)/tuned/%-coupled-tuned.json:
	@mkdir -p $(@D)
	$(SENSORLESS) tune $* --budget $(BUDGET) --set estimator=coupled --out $@

.PHONY: rules
rules: $(OTHERS:%=$(OUT)/others/%.json)
	cp $^ $(SHIPPED)/tuned

$(OUT)/others/%.json:
	@mkdir -p $(@D)
	$(SENSORLESS) $$($(PYTHON) -c "import json; of = json.load(open('$(SHIPPED)/tuned/$*.json')); \
	  print(of['provenance']['command'].split(' --out ')[0].removeprefix('sensorless '))") --out $@

# From Eq. 25. A training that was interrupted starts again: resumed, it would not give the same bits.
# It runs in a folder of its own, so that no path is recorded with it.
$(OUT)/seed-%/table.json:
	@rm -rf $(WORK)/$(@D); mkdir -p $(WORK)/$(@D) $(@D)
	cd $(WORK)/$(@D) && $(SENSORLESS) train --name run --seed $* $(TRAIN) --set estimator=coupled
	@cd $(WORK)/$(@D)/runs/run && cp config.json progress.csv table.json $(abspath $(@D))

# The seed that was best in validation, on scenarios that judging does not see.
$(OUT)/table.json: $(RUNS)
	@best=$$(for run in $(^D); do awk -F, -v run=$$run 'NR > 1 && (best == "" || $$6 < best) { best = $$6 } \
	  END { print best, run }' $$run/progress.csv; done | sort -g | head -n 1 | cut -d ' ' -f 2); \
	echo "best in validation: $$best"; cp $$best/config.json $$best/progress.csv $$best/table.json $(@D)

$(OUT)/report/index.html: $(OUT)/table.json $(TUNED)
	@rm -rf $(@D)
	$(SENSORLESS) report $(OUT) --size $(SIZE) --seed $(SEED) --grid $(GRID) $(SUITES:%=--suite %) \
	  $(JUDGED:%=--policy %)
