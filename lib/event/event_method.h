/* The method event: its parts, and what their files do for a step (event.c). */
#ifndef NSDAE_EVENT_METHOD_H
#define NSDAE_EVENT_METHOD_H

#include "instant.h"
#include "integrator.h"
#include "phase.h"

/* ---- memory.c: what is kept from step to step: the last instant, and how to come from there to
 * now. */

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

/* ---- event.c */

/* At a pole a force grows as (t_pole - t)^-1/2 at least, over a time tau. A zero is located up to
 * 100 eps t. So this share is left of the acceleration that a unit of the force gives alone, if tau
 * is above 2.2e-8 t. */
#define NSDAE_EVENT_POLE 1e-3

typedef struct nsdae_event {
  nsdae_stepper *tools;
  nsdae_arena arena;
  nsdae_event_setting setting;
  nsdae_event_phase phase;
  nsdae_event_roots roots;
  nsdae_event_integrator integrator;
  nsdae_event_account account;
  nsdae_event_instant instant;
  nsdae_event_base base;
  int *mode_before, *slide_mode_before; /* k, f */
  double reached;                       /* accounted for up to here */
  long stamp, stamps;                   /* of the memory that the integrator is at; given so far */
} nsdae_event;

/* ---- mode_change.c: the events between the smooth phases. A failure has its record. */

/* A failure of the integrator at t, where its y is; what has a record already keeps it. */
int nsdae_event_failed(nsdae_event *event, int status, double t);

/* The integrator as a phase begins; it starts at t, which is the base from now on. */
void nsdae_event_set_integrator(nsdae_event *event);
int nsdae_event_start(nsdae_event *event, double t);

/* Tolerances of contacts that chatter; steps of differences for the motion at t. */
void nsdae_event_blur(nsdae_event *event);
int nsdae_event_tune(nsdae_event *event, double t);

/* The event at t at the state of the integrator's y, and the start of the next phase. */
int nsdae_event_restart(nsdae_event *event, double t);
/* The same in the middle of a run, with the changes of mode; the forces are in y. */
int nsdae_event_change_modes(nsdae_event *event, double t);
/* The same at roots, of which one may be the pole of a force. */
int nsdae_event_go_through(nsdae_event *event, double t);

/* ---- contacts of a list in slots; nothing is done for fixed contacts. NSDAE_OK,
 * NSDAE_ARRAYS_GROW, or what the terms return. */

/* Contacts that are new in their slots do not chatter. */
void nsdae_event_slots_settle(nsdae_event *event);
/* Slots at the start of a run; for what touches at t and has none, as another feature than before;
 * at the start of a dt slots of what is open and far are free. */
int nsdae_event_slots_begin(nsdae_event *event, const nsdae_terms *from);
int nsdae_event_slots_add(nsdae_event *event, double t);
int nsdae_event_slots_trim(nsdae_event *event, const nsdae_terms *from);
/* The table at the start of a motion without a memory. */
int nsdae_event_slots_anew(void *event, nsdae_terms *at, double h);
/* Gaps at both ends of a step, at its end of all contacts that did something in it. */
int nsdae_event_slots_show(nsdae_event *event, nsdae_terms *from);

/* ---- event_certificate.c: the certificate of a record, see certificate.c */

/* Whether the step's result, which started at `from` and whose end is the point in work, fulfils
 * the laws of contact. NSDAE_OK; or NSDAE_E_CONVERGENCE with the record, which names the contact or
 * constraint; or a callback's status. */
int nsdae_event_certify(const nsdae_event_phase *phase, const nsdae_terms *from);

/* ---- Contacts whose normal turns faster than the steps: a gap with a kink, as of a disc
 * that falls flat. */

/* Constraints or closed contacts strayed at the point in work, and the error says so: where a
 * contact has a kink in its gap within dt of motion, the error names it instead. q [nq] is work.
 * Returns the error's status. */
int nsdae_event_explain_strayed(nsdae_event_instant *instant, double *q);

#endif
