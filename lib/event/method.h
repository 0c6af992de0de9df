/* What the method keeps: its parts, and the step in work. */
#ifndef NSDAE_EVENT_METHOD_H
#define NSDAE_EVENT_METHOD_H

#include "instant.h"
#include "stepper.h"

typedef struct nsdae_event_method {
  nsdae_stepper *stepper;
  nsdae_arena arena;
  nsdae_event_setting setting;
  nsdae_event_phase phase;
  nsdae_event_roots roots;
  nsdae_event_integrator integrator;
  nsdae_event_account account;
  nsdae_event_instant instant;
  int *mode_before, *slide_mode_before; /* k, f */
  double since, reached;                /* the last instant; accounted for up to here */
  int running;                          /* goes on from the last step */
  int instants, idle;                   /* in this dt; of those, without a change */
} nsdae_event_method;

#endif
