/* The port for a Cortex-M4F under QEMU: semihosting and SysTick. */
#include "port.h"

enum { SYS_OPEN = 1, SYS_WRITE = 5, SYS_READ = 6, SYS_EXIT_EXTENDED = 0x20 };
enum { MODE_READ = 1, MODE_WRITE = 5 }; /* "rb", "wb" */

#define SYST_CSR (*(volatile uint32_t *)0xE000E010UL)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014UL)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018UL)

static uint32_t from_host;
static uint32_t to_host;

static uint32_t call(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = argument;
    __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static uint32_t open_file(const char *name, uint32_t length, uint32_t mode) {
    uint32_t block[3] = {(uint32_t)name, mode, length};
    return call(SYS_OPEN, block);
}

int port_open(void) {
    SYST_RVR = 0xFFFFFFUL;
    SYST_CVR = 0;
    SYST_CSR = 5; /* processor clock, no interrupt */
    from_host = open_file("to_target", 9, MODE_READ);
    to_host = open_file("to_host", 7, MODE_WRITE);
    return from_host != 0xFFFFFFFFUL && to_host != 0xFFFFFFFFUL;
}

/* Both operations return the number of bytes not transferred. */
static int transfer(uint32_t operation, uint32_t file, uint32_t address, uint32_t n) {
    uint32_t bytes = 4 * n;
    while (bytes > 0) {
        uint32_t block[3] = {file, address, bytes};
        uint32_t left = call(operation, block);
        if (left >= bytes) {
            return 0;
        }
        address += bytes - left;
        bytes = left;
    }
    return 1;
}

int port_read(void *words, uint32_t n) { return transfer(SYS_READ, from_host, (uint32_t)words, n); }

int port_write(const void *words, uint32_t n) {
    return transfer(SYS_WRITE, to_host, (uint32_t)words, n);
}

uint32_t port_ticks(void) { return 0xFFFFFFUL - SYST_CVR; }

__attribute__((noinline)) void port_thousand(void) { __asm volatile(".rept 1000\n nop\n .endr"); }

void port_exit(int status) {
    uint32_t block[2] = {0x20026UL /* application exit */, (uint32_t)status};
    call(SYS_EXIT_EXTENDED, block);
    for (;;) {
    }
}
