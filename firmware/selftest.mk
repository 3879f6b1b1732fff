# make selftest: does this folder, compiled here, compute what it computed where it was exported?

CC       ?= cc
CFLAGS   ?= -O2
FLAGS    := -std=c99 -ffp-contract=off -fno-math-errno -fno-trapping-math
WARNINGS ?= -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
SOURCES  := $(wildcard core/*.c cmsis/*.c) ks_table_data.c ks_table_q15.c

.PHONY: selftest clean
selftest: build/selftest
	@build/selftest

build/selftest: $(wildcard test/*.c) $(SOURCES) $(wildcard *.h core/*.h cmsis/*.h test/*.h) Makefile
	@mkdir -p build
	$(CC) $(FLAGS) $(CFLAGS) $(WARNINGS) -o $@ $(wildcard test/*.c) $(SOURCES)

clean:
	rm -rf build
