# make selftest: does this folder, compiled here, compute what it computed where it was exported?

CC       ?= cc
CFLAGS   ?= -O2
FLAGS    := -std=c99 -ffp-contract=off -fno-math-errno -fno-trapping-math
WARNINGS ?= -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
SOURCES  := $(wildcard test/*.c core/*.c cmsis/*.c) params.c ks_hook_params.c \
            ks_table_data.c ks_table_q15.c
OBJECTS  := $(SOURCES:%.c=build/%.o)
SHIPPED  := $(SOURCES) $(wildcard *.h core/*.h test/*.h)

# The schedule in a drive with its own observers, and a bare Cortex-M4F.
HOOK     := core/ks_hook.c core/ks_schedule.c core/ks_table.c ks_hook_params.c ks_table_data.c
CROSS    ?= arm-none-eabi-
M4       := -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -ffreestanding \
            -fno-tree-loop-distribute-patterns

.PHONY: selftest example cortex_m4 clean
selftest: build/selftest
	@build/selftest; status=$$?; \
	if test -f SHA256SUMS && command -v sha256sum >/dev/null; then \
	 ( sha256sum --quiet --strict -c SHA256SUMS 2>/dev/null && \
	   for file in $(SHIPPED); do grep -q "  $$file\$$" SHA256SUMS || exit 1; done ) || \
	 echo "note: not as exported; the self test sees what a file computes, not every number in it"; fi; \
	exit $$status

build/selftest: $(OBJECTS)
	@$(CC) $(FLAGS) $(CFLAGS) -o $@ $^

example: build/foreign_drive
	@build/foreign_drive

build/foreign_drive: $(HOOK) example/foreign_drive.c
	@mkdir -p $(@D)
	@$(CC) $(FLAGS) $(CFLAGS) $(WARNINGS) -o $@ $^

# One object with everything but your start-up file. SHAFT_ANGLE: where an aligned shaft stands [rad].
cortex_m4: $(wildcard core/*.c) params.c ks_table_data.c example/cortex_m4.c
	@mkdir -p build
	@$(CROSS)gcc $(FLAGS) $(CFLAGS) $(if $(SHAFT_ANGLE),-DSHAFT_ANGLE=$(SHAFT_ANGLE)) $(M4) $(WARNINGS) \
	 -r -nostdlib -o build/cortex_m4.o $^

build/%.o: %.c Makefile
	@mkdir -p $(@D)
	@$(CC) $(FLAGS) $(CFLAGS) $(WARNINGS) -MMD -c -o $@ $<

-include $(OBJECTS:.o=.d)

clean:
	rm -rf build
