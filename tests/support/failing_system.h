/* Any system, each callback counted, and one call of one that fails after it wrote its arrays; or
 * somewhere else: with coordinates q + shift where it had q. */
#ifndef NSDAE_TESTS_FAILING_SYSTEM_H
#define NSDAE_TESTS_FAILING_SYSTEM_H

#include <nsdae/nsdae.h>

#include "system_impl.h"

enum { FAILING_TERMS = 15, FAILING_NQ = 32 };

typedef struct failing_system {
  const nsdae_system *inner;
  int term; /* of failing_name; -1: none fails */
  long at;  /* the call of it that does, from 0 */
  int code; /* what it returns */
  long calls[FAILING_TERMS];
  double shift, q[FAILING_NQ]; /* 0 when made; where the inner system is, in work */
} failing_system;

/* The same description as inner, which must outlive it. */
nsdae_system *failing_system_make(failing_system *f, const nsdae_system *inner);
/* Counts from 0 again. */
void failing_system_rewind(failing_system *f);
const char *failing_name(int term);

#endif
