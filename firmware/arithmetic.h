/* Whether this program computes as the core needs: plain IEEE 754 single precision. */
#ifndef ARITHMETIC_H
#define ARITHMETIC_H

#ifdef __cplusplus
extern "C" {
#endif

/* What is wrong with the arithmetic, and what to do about it; 0 if nothing is. */
const char *arithmetic_fault(void);

#ifdef __cplusplus
}
#endif

#endif
