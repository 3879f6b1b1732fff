/* Reset of the Cortex-M4F: FPU on, memory set up, main, end; without a C library. */
#include <stdint.h>

#include "port.h"

/* From the linker script: addresses, and their numbers of words. */
extern uint32_t data_load[], data_start[], bss_start[], stack_top[];
extern const uint32_t data_words, bss_words;

int main(void);
void reset(void);
void reset_c(void);
void trap(void);

/* CPACR: full access to coprocessors 10 and 11. In assembly, because a C function may save FPU
 * registers before its first statement. */
__attribute__((naked, noreturn)) void reset(void) {
    __asm volatile("ldr r0, =0xE000ED88\n"
                   "ldr r1, [r0]\n"
                   "orr r1, r1, #0xF00000\n"
                   "str r1, [r0]\n"
                   "dsb\n"
                   "isb\n"
                   "b reset_c\n");
}

__attribute__((used, noreturn)) void reset_c(void) {
    for (uint32_t j = 0; j < data_words; j++) {
        data_start[j] = data_load[j];
    }
    for (uint32_t j = 0; j < bss_words; j++) {
        bss_start[j] = 0;
    }
    port_exit(main());
}

/* Any exception is a fault, because no interrupt is in use. */
__attribute__((noreturn)) void trap(void) { port_exit(99); }

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_top,          (const void *)reset, (const void *)trap, (const void *)trap,
    (const void *)trap, (const void *)trap,  (const void *)trap, (const void *)trap,
    (const void *)trap, (const void *)trap,  (const void *)trap, (const void *)trap,
    (const void *)trap, (const void *)trap,  (const void *)trap, (const void *)trap,
};
