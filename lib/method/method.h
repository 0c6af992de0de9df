/* The interface of a method. */
#ifndef NSDAE_METHOD_H
#define NSDAE_METHOD_H

#include "result.h"

struct nsdae_stepper;

typedef struct nsdae_stepping {
  const char *name, *summary;

  /* What it works with beside the stepper, made once: *own, also where it fails, to be destroyed.
   * NULL: nothing, and own is the stepper. */
  int (*create)(struct nsdae_stepper *stepper, void **own);
  void (*destroy)(void *own);

  /* Takes what it keeps between steps, before create, too. Of a method that gives up, the first is
   * the contacts' warm start (nsdae_stepper_lay), so that implicit can step in. */
  void (*lay)(const struct nsdae_stepper *stepper, nsdae_memory_part *part);

  /* Settings or coefficients changed; NULL where nothing is made of them beside the stepper. */
  int (*prepare)(void *own);

  /* A run starts at the terms' point: what it takes of memory that depends on the model's pattern;
   * NULL: nothing. */
  int (*start)(void *own, const nsdae_terms *at);

  /* Leaves in the result's memory that the integrator starts anew at the state, whatever led there;
   * NULL where nothing of it is kept beside the memory. Then the end of a step also tells what is
   * between: see nsdae_sim_interpolate. */
  int (*settle)(void *own, const nsdae_state *state, nsdae_result *result);

  /* Leaves in the settled memory that accelerations and velocities of motors jump at the state;
   * NULL: it keeps neither. */
  void (*jump)(void *own, nsdae_memory *memory);

  /* Whether the memory, which is of a block, is one that this method can leave there: NSDAE_OK or
   * NSDAE_E_ARGUMENT; NULL: no number in it leads anywhere. */
  int (*check)(void *own, nsdae_memory *memory);

  /* From the state to t_end, into the result, which comes cleared and with the state's memory. A
   * status < 0 drops the result; the error record says why. */
  int (*advance)(void *own, const nsdae_state *state, double t_end, nsdae_result *result);

  /* Of tracked contacts: what the list has within the way of a time h from the terms' point gets
   * slots, in place of what was in the table. NSDAE_ARRAYS_GROW: as advance. */
  int (*track)(void *own, nsdae_terms *at, double h);

  int tracks; /* takes a contact list as contacts in slots: see tracked.h */
  int closes; /* starts with nsdae_step_close, which clears the impulses */
} nsdae_stepping;

#endif
