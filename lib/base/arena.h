/* One block of memory per handle. A layout function takes its arrays from the arena; run once
 * on an empty arena it measures, run again on the allocated block it hands the arrays out. So
 * sizes are written once and nothing is allocated after creation. */
#ifndef NSDAE_BASE_ARENA_H
#define NSDAE_BASE_ARENA_H

#include <stddef.h>

/* Arrays that grow together, between steps. */

typedef struct nsdae_array {
  void *at;     /* address of the pointer to the array, which is NULL at first */
  size_t entry; /* bytes for each of the number that is asked for */
} nsdae_array;

#define NSDAE_ARRAY(array, each)               \
  {                                            \
    &(array), (size_t)(each) * sizeof *(array) \
  }

/* Room for this number in each; their entries stay. 0, or NSDAE_E_MEMORY. */
int nsdae_arrays_grow(const nsdae_array *arrays, size_t count, size_t room);
/* Releases each and sets it to NULL. */
void nsdae_arrays_release(const nsdae_array *arrays, size_t count);

/* The arrays of a layout, in their order. */
typedef struct nsdae_arena_log {
  size_t *bytes; /* of each; NULL: they are counted */
  size_t count,
      at; /* so far; of those before the next one in the block that they are copied from */
  const char *from; /* that block; NULL: nothing is copied */
} nsdae_arena_log;

typedef struct nsdae_arena {
  char *base; /* NULL while measuring */
  size_t used;
  size_t size;          /* bytes of the block */
  int overflow;         /* a size was negative or the sum does not fit size_t */
  nsdae_arena_log *log; /* or NULL */
} nsdae_arena;

/* count entries of the given size, aligned to 64 bytes and zeroed; NULL while measuring. */
void *nsdae_arena_take(nsdae_arena *arena, long count, size_t size);

#define NSDAE_ARENA_DOUBLES(arena, count) \
  ((double *)nsdae_arena_take((arena), (long)(count), sizeof(double)))
#define NSDAE_ARENA_INTS(arena, count) \
  ((int *)nsdae_arena_take((arena), (long)(count), sizeof(int)))

/* count entries each for the arrays whose addresses are in a list that ends with NULL. */
void nsdae_arena_doubles(nsdae_arena *arena, long count, double **const list[]);
void nsdae_arena_ints(nsdae_arena *arena, long count, int **const list[]);

/* Runs layout twice around one allocation; the block is at arena->base, to be released with
 * nsdae_arena_release. Returns 0 or NSDAE_E_MEMORY. */
int nsdae_arena_build(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                      void *object);
/* The same, but in the block that the arena has where that is large enough: what it held is then
 * still there, and not zeros. */
int nsdae_arena_fit(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                    void *object);
void nsdae_arena_release(nsdae_arena *arena);

/* Arrays of other lengths, after `change`, in a new block: each begins with what it had, up to
 * where the layout calls nsdae_arena_zeros, and it takes as many arrays there before and after.
 * *old is the block of before, to be released: after NSDAE_E_MEMORY the object is as it was, and
 * *old is empty. back: `change` undoes itself. */
int nsdae_arena_resize(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                       void (*change)(void *object, int back), void *object, nsdae_arena *old);
/* The arrays that follow are zeros in a new block. */
static inline void nsdae_arena_zeros(nsdae_arena *arena)
{
  arena->log = NULL;
}
/* Undoes it. */
void nsdae_arena_restore(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                         void (*change)(void *object, int back), void *object, nsdae_arena *old);

#endif
