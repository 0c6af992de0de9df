/* The calls of a program's own objects to HDF5, of which one can be made to fail. */
#ifndef NSDAE_TESTS_HDF5_CALLS_H
#define NSDAE_TESTS_HDF5_CALLS_H

#include "call_places.h"

typedef struct hdf5_calls {
  long calls;
  long fail_at;       /* the number, from 0, of the call that fails; -1: none */
  const char *failed; /* the function whose call did; NULL: none */
  int listing;        /* addresses that tell a place (call_places.h) of those to note; 0: none */
  call_places places;
} hdf5_calls;

extern hdf5_calls the_hdf5;

/* Counts from 0 again; places that were noted stay. */
void hdf5_calls_reset(long fail_at);

#endif
