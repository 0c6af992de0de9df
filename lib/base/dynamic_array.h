/* Arrays that grow together, between steps. */
#ifndef NSDAE_BASE_GROW_H
#define NSDAE_BASE_GROW_H

#include <stddef.h>

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

#endif
