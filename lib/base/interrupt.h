/* Somebody who may want a computation to end. */
#ifndef NSDAE_BASE_INTERRUPT_H
#define NSDAE_BASE_INTERRUPT_H

#include "errors.h"

typedef struct nsdae_interrupt {
  int (*asked)(void *user); /* NULL: nobody */
  void *user;
} nsdae_interrupt;

/* NSDAE_OK, or NSDAE_E_INTERRUPTED with the record where it is asked for. */
static inline int nsdae_interrupted(const nsdae_interrupt *interrupt, nsdae_error *error, double t)
{
  if (!interrupt->asked) return NSDAE_OK;
  int code = interrupt->asked(interrupt->user);
  if (code == 0) return NSDAE_OK;
  nsdae_error_set(error, NSDAE_E_INTERRUPTED, "nsdae_sim", "",
                  "interrupted at t = %.17g: the step was discarded", t);
  if (error) {
    error->code = code;
    error->time = t;
  }
  return NSDAE_E_INTERRUPTED;
}

#endif
