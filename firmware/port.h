/* What the processor-in-the-loop program needs from the emulated target, or from a host. */
#ifndef SENSORLESS_PORT_H
#define SENSORLESS_PORT_H

#include <stdint.h>

/* Connects to the other side. Returns 0 if there is none. */
int port_open(void);

/* Read or write exactly n 32-bit words. Return 0 if the other side is gone. */
int port_read(void *words, uint32_t n);
int port_write(const void *words, uint32_t n);

/* The low 24 bits of a running count with a fixed number of ticks per instruction; or always 0. */
uint32_t port_ticks(void);

/* Ticks since `start`, a value of port_ticks. */
static inline uint32_t port_since(uint32_t start) { return (port_ticks() - start) & 0xFFFFFFUL; }

/* A thousand instructions, plus those of the call, to find the ticks of one. */
void port_thousand(void);

__attribute__((noreturn)) void port_exit(int status);

#endif
