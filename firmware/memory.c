/* memcpy and memset for struct copies that the compiler turns into calls; no C library is
 * linked. */
#include <stddef.h>

void *memcpy(void *to, const void *from, size_t n);
void *memset(void *to, int value, size_t n);

void *memcpy(void *to, const void *from, size_t n) {
    char *a = to;
    const char *b = from;
    while (n-- > 0) {
        *a++ = *b++;
    }
    return to;
}

void *memset(void *to, int value, size_t n) {
    char *a = to;
    while (n-- > 0) {
        *a++ = (char)value;
    }
    return to;
}
