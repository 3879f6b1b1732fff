# Makes the reference anew: `make reference` in the folder above. All work is done in build/reference,
# where an interrupted run resumes; at the end results/reference is replaced by what was made.
# Delete a file of build/reference to have it made again.
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
GRID   ?= 41
RULES  ?= linear smoothstep sine quadratic hysteresis ramp gated emf physics fusion error_blend \
          flux_observer fuzzy logistic grid
# On the flux observer in place of the sliding-mode one; flux_observer is the ramp there.
FLUX_RULES ?= hysteresis gated fuzzy logistic grid

TUNED := $(RULES:%=$(OUT)/tuned/%-tuned.json) $(FLUX_RULES:%=$(OUT)/tuned/%-flux-tuned.json)
# PPO on the flux observer from the tuned logistic rule and from Eq. 25, and on the SMO.
RUNS  := $(SEEDS:%=$(OUT)/seed-%/table.json)
FRESH := $(SEEDS:%=$(OUT)/fresh-%/table.json)
SMO   := $(SEEDS:%=$(OUT)/sliding-mode/seed-%/table.json)
# A wide band beside flux_observer-tuned: the search ends where few scenarios are lost and keeps its start.
JUDGED := eq25 hfi smo hysteresis fuzzy flux_observer:50,600 $(TUNED) $(SEEDS:%=$(OUT)/seed-%) $(SEEDS:%=$(OUT)/fresh-%) \
          $(OUT)/sliding-mode oracle sensored

.PHONY: all
.DELETE_ON_ERROR:

all: $(OUT)/report/index.html
	$(PYTHON) studies/publish_reference.py $(OUT) $(SHIPPED)

$(OUT)/tuned/%-tuned.json:
	@mkdir -p $(@D)
	$(SENSORLESS) tune $* --budget $(BUDGET) --out $@

$(OUT)/tuned/%-flux-tuned.json:
	@mkdir -p $(@D)
	$(SENSORLESS) tune $* --budget $(BUDGET) --set estimator=flux --out $@

# A training that was interrupted starts again: resumed, it would not give the same bits. $(1): its
# seed, $(2): its settings. The start is copied to where training runs, so that no path is recorded with it.
define train
@rm -rf $(WORK)/$(@D); mkdir -p $(WORK)/$(@D) $(@D)
@for start in $(filter %-tuned.json,$^); do cp $$start $(WORK)/$(@D); done
cd $(WORK)/$(@D) && $(SENSORLESS) train --name run --seed $(1) $(TRAIN) $(2)
@cd $(WORK)/$(@D)/runs/run && cp config.json progress.csv table.json $(abspath $(@D))
endef

REFINE := --axes start --noise 0.06 --lr-nodes 6e-3
comma  := ,
WIDE   := speed:16$(comma)torque_current:-1.5:1.5:5$(comma)disagreement:-1.5:1.5:5

$(OUT)/seed-%/table.json: $(OUT)/tuned/logistic-flux-tuned.json
	$(call train,$*,--set estimator=flux --start logistic-flux-tuned.json $(REFINE))

$(OUT)/fresh-%/table.json:
	$(call train,$*,--set estimator=flux)

$(OUT)/sliding-mode/seed-%/table.json: $(OUT)/tuned/linear-tuned.json
	$(call train,$*,--start linear-tuned.json --axes '$(WIDE)')

# The seed that was best in validation, on scenarios that judging does not see.
define best
@best=$$(for run in $(^D); do awk -F, -v run=$$run 'NR > 1 && (best == "" || $$6 < best) { best = $$6 } \
  END { print best, run }' $$run/progress.csv; done | sort -g | head -n 1 | cut -d ' ' -f 2); \
echo "best in validation: $$best"; cp $$best/config.json $$best/progress.csv $$best/table.json $(@D)
endef

$(OUT)/table.json: $(RUNS) $(FRESH)
	$(best)

$(OUT)/sliding-mode/table.json: $(SMO)
	$(best)

$(OUT)/report/index.html: $(OUT)/table.json $(OUT)/sliding-mode/table.json $(TUNED)
	@rm -rf $(@D)
	$(SENSORLESS) report $(OUT) --size $(SIZE) --seed $(SEED) --grid $(GRID) $(JUDGED:%=--policy %)
