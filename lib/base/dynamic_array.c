#include "dynamic_array.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/status.h>

int nsdae_arrays_grow(const nsdae_array *arrays, size_t count, size_t room)
{
  for (size_t i = 0; i < count; i++) {
    void *array; /* pointers to objects of all types look alike wherever this is built */
    memcpy(&array, arrays[i].at, sizeof array);
    if (arrays[i].entry > 0 && room > SIZE_MAX / 2 / arrays[i].entry) return NSDAE_E_MEMORY;
    void *grown = realloc(array, room * arrays[i].entry + 1);
    if (!grown) return NSDAE_E_MEMORY;
    memcpy(arrays[i].at, &grown, sizeof grown);
  }
  return NSDAE_OK;
}

void nsdae_arrays_release(const nsdae_array *arrays, size_t count)
{
  for (size_t i = 0; i < count; i++) {
    void *array;
    memcpy(&array, arrays[i].at, sizeof array);
    free(array);
    memset(arrays[i].at, 0, sizeof array);
  }
}
