/* The calls of a program's own objects to HDF5, of which one can be made to fail. */
#ifndef NSDAE_TESTS_HDF5_CALLS_H
#define NSDAE_TESTS_HDF5_CALLS_H

enum { HDF5_CALLS = 8192 };

typedef struct hdf5_calls {
  long calls;
  long fail_at;       /* the number, from 0, of the call that fails; -1: none */
  const char *failed; /* the function whose call did; NULL: none */
  int listing;        /* whether places are noted: of the call and what led to it */
  unsigned long place[HDF5_CALLS];
} hdf5_calls;

extern hdf5_calls the_hdf5;

/* Counts from 0 again; places that were noted stay. */
void hdf5_calls_reset(long fail_at);

#endif
