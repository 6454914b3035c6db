/* Lets the N-th large allocation fail: a library for LD_PRELOAD, Linux with glibc.
 *
 * DOUBLET_LARGE_ALLOCATION is from how many bytes on one is large, 1 MB without.
 * DOUBLET_FAIL_ALLOCATION is N, 0 for none; DOUBLET_ALLOCATIONS names a file that gets their number when the program ends.
 */
#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *memory, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

static atomic_long count;
static long which;
static size_t large = (size_t)1 << 20;

__attribute__((constructor)) static void begin(void) {
    const char *text = getenv("DOUBLET_FAIL_ALLOCATION");
    which = text ? atol(text) : 0;
    text = getenv("DOUBLET_LARGE_ALLOCATION");
    large = text ? (size_t)atol(text) : large;
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("DOUBLET_ALLOCATIONS");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    fprintf(file, "%ld\n", (long)count);
    fclose(file);
}

static int fails(size_t size) {
    return size >= large && atomic_fetch_add(&count, 1) + 1 == which;
}

void *malloc(size_t size) { return fails(size) ? (errno = ENOMEM, NULL) : __libc_malloc(size); }

void *calloc(size_t number, size_t size) {
    size_t all;
    int is_over = __builtin_mul_overflow(number, size, &all);
    return !is_over && fails(all) ? (errno = ENOMEM, NULL) : __libc_calloc(number, size);
}

void *realloc(void *memory, size_t size) { return fails(size) ? (errno = ENOMEM, NULL) : __libc_realloc(memory, size); }

int posix_memalign(void **memory, size_t alignment, size_t size) {
    if (fails(size)) return ENOMEM;
    void *found = __libc_memalign(alignment, size);
    if (!found) return ENOMEM;
    *memory = found;
    return 0;
}

void *aligned_alloc(size_t alignment, size_t size) { return fails(size) ? (errno = ENOMEM, NULL) : __libc_memalign(alignment, size); }
