/* What is kept from step to step: the last instant, and how to come from there to now. */
#ifndef NSDAE_EVENT_MEMORY_H
#define NSDAE_EVENT_MEMORY_H

#include "instant.h"
#include "integrator.h"
#include "phase.h"

/* Over the numbers of a result's memory, as the modes are. */
typedef struct nsdae_event_base {
  int *basis[2];               /* warm starts: of impacts, of accelerations */
  double *t, *y, *direction;   /* 1, nq + nv, k nt: where the integrator started last, */
  double *slow, *none, *blur;  /* and the modes': 1, 1, k */
  int *steps;                  /* of its own since then */
  double *h;                   /* the next step there */
  double *goal;                /* of the dt in work, which may take several steps */
  int *instants, *idle, *tiny; /* in it; of those, without an impact or a change; steps of no use */
  int *finer;                  /* 2: of the differences, since they were last tuned */
  double *difference_error;    /* 2: the setting's, from there */
  nsdae_chattering rattle;
  int *late; /* k: its slot has the contact since then; of tracked contacts */
} nsdae_event_base;

/* What this takes. */
void nsdae_event_memory_lay(const nsdae_stepper *stepper, nsdae_memory_part *part);

/* Lays the base, the modes and the warm starts of the instant's problems over a memory. */
void nsdae_event_lay(nsdae_event_base *base, nsdae_event_instant *instant, nsdae_tracking *tracking,
                     const nsdae_stepper *stepper, nsdae_memory *memory);

/* The base is here, where the integrator is about to start; and back to it. */
void nsdae_event_save(nsdae_event_base *base, const nsdae_event_integrator *integrator, double t);
void nsdae_event_restore(const nsdae_event_base *base, nsdae_event_integrator *integrator);

#endif
