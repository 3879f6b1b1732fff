# make selftest: does this folder, compiled here, compute what it computed where it was exported?

CC       ?= cc
CFLAGS   ?= -O2
FLAGS    := -std=c99 -ffp-contract=off -fno-math-errno -fno-trapping-math
WARNINGS ?= -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
SOURCES  := $(wildcard test/*.c core/*.c cmsis/*.c) params.c ks_table_data.c ks_table_q15.c
OBJECTS  := $(SOURCES:%.c=build/%.o)

.PHONY: selftest clean
selftest: build/selftest
	@build/selftest

build/selftest: $(OBJECTS)
	@$(CC) $(FLAGS) $(CFLAGS) -o $@ $^

build/%.o: %.c Makefile
	@mkdir -p $(@D)
	@$(CC) $(FLAGS) $(CFLAGS) $(WARNINGS) -MMD -c -o $@ $<

-include $(OBJECTS:.o=.d)

clean:
	rm -rf build
