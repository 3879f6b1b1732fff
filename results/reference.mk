# Makes all of results/reference: `make reference` in the folder above. What is there is kept, so that
# an interrupted run is gone on with by the same command; delete a file to have it made again.
SENSORLESS ?= $(abspath .venv/bin/sensorless)
OUT        ?= results/reference
WORK       ?= build/reference

# Simulated seconds for every rule, and about as many for PPO: decisions of 5 ms.
BUDGET ?= 50000
TRAIN  ?= --steps 10000000
SEEDS  ?= 1 2 3 4 5
SIZE   ?= 2000
# Of the scenarios to judge on.
SEED   ?= 11
GRID   ?= 41
RULES  ?= linear smoothstep sine quadratic hysteresis ramp gated emf physics fusion error_blend \
          flux_observer fuzzy logistic grid

TUNED := $(RULES:%=$(OUT)/tuned/%-tuned.json)
RUNS  := $(SEEDS:%=$(OUT)/seed-%/table.json)
JUDGED := eq25 hfi smo hysteresis fuzzy $(TUNED) $(SEEDS:%=$(OUT)/seed-%) oracle sensored

.PHONY: all
.DELETE_ON_ERROR:

all: $(OUT)/report/index.html

$(OUT)/tuned/%-tuned.json:
	@mkdir -p $(@D)
	$(SENSORLESS) tune $* --budget $(BUDGET) --out $@

# A run that was interrupted starts again: resumed it would not be the same.
$(OUT)/seed-%/table.json:
	@rm -rf $(WORK)/runs/seed-$*; mkdir -p $(WORK) $(@D)
	cd $(WORK) && $(SENSORLESS) train --name seed-$* --seed $* $(TRAIN)
	@cd $(WORK)/runs/seed-$* && cp config.json progress.csv table.json $(abspath $(@D))

# The seed that was best in validation, on scenarios that judging does not see.
$(OUT)/table.json: $(RUNS)
	@best=$$(for run in $(^D); do awk -F, -v run=$$run 'NR > 1 && (best == "" || $$6 < best) { best = $$6 } \
	  END { print best, run }' $$run/progress.csv; done | sort -g | head -n 1 | cut -d ' ' -f 2); \
	echo "best in validation: $$best"; cp $$best/config.json $$best/progress.csv $$best/table.json $(OUT)

$(OUT)/report/index.html: $(OUT)/table.json $(TUNED)
	@rm -rf $(@D)
	$(SENSORLESS) report $(OUT) --size $(SIZE) --seed $(SEED) --grid $(GRID) $(JUDGED:%=--policy %)
