/* A system by blocks as a plain dense one: M and Phi_q are dense matrices, all other callbacks and
 * coefficients are the same. One copy at a time. */
#ifndef NSDAE_TESTS_DENSE_COPY_H
#define NSDAE_TESTS_DENSE_COPY_H

#include <nsdae/nsdae.h>

/* The system must outlive its copy. NULL without memory, or with a contact list. */
nsdae_system *dense_copy(const nsdae_system *system);

#endif
