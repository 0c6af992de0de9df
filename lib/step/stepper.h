/* What every time-stepping method works with. A method moves from the terms of the start of a
 * step to those of its end; the simulation swaps the two when the step was done, so a step that
 * fails leaves the state as it was. */
#ifndef NSDAE_STEPPER_H
#define NSDAE_STEPPER_H

#include <nsdae/sim.h>

#include "contacts.h"
#include "kkt.h"
#include "newmark.h"
#include "system_impl.h"
#include "terms.h"

typedef struct nsdae_stepper nsdae_stepper;

typedef struct nsdae_stepping {
  const char *name, *summary;
  /* From stepper->start to stepper->end, at t_end, in h; fills contacts, multiplier, counters. */
  int (*advance)(nsdae_stepper *stepper, double h);
  /* What a method keeps for itself, in stepper->own; NULL where it keeps nothing. */
  int (*create)(nsdae_stepper *stepper);
  void (*destroy)(nsdae_stepper *stepper);
  int finds_impacts; /* fills stepper->impact itself, and may end a step before t_end */
} nsdae_stepping;

struct nsdae_stepper {
  const nsdae_system *system;
  const nsdae_sim_options *options;
  nsdae_error *error;
  const nsdae_stepping *method;
  double iteration_tol; /* the option, but above the rounding of derivatives by differences */
  double t_end;         /* of the step: start.t + h but for rounding */
  nsdae_evals evals;
  nsdae_differences differences;
  nsdae_terms start, middle, end;
  nsdae_kkt kkt;
  nsdae_contacts contacts;
  const nsdae_contacts *problem; /* whose complementarity problem was the last: contacts, or own */
  nsdae_newmark newmark;
  double *M;                /* nv x nv: a mean mass matrix */
  double *q, *v, *r, *last; /* nq, nv, nv, nv */
  double *size;             /* nv: how large the terms of a velocity are */
  double *qdot0, *qdot1;    /* nq */
  double *impulse;          /* m: Lambda of the bilateral constraints over the step */
  double *multiplier;       /* m: its mean force */
  void *own;                /* the method's */
  int fresh;                /* the first step after an init */
  double work;              /* of contact and friction impulses in the step */
  nsdae_impact *impact;     /* impacts_max: those of the step */
  int impacts, impacts_max;
  nsdae_change *change; /* changes_max: changes of mode in the step */
  int changes, changes_max;
  double worst_residual;             /* of the LCPs of the step */
  int smooth;                        /* the step had no closed contact */
  int rank, rank_most;               /* smallest and largest rank of Phi_q so far */
  long lcps, lcp_pivots, iterations; /* over the whole run */
  long events, accumulations, fallbacks;
  int changed, settled; /* of event: instants and accumulations in the step */
  int stepped_over;     /* of a method that finds impacts: not in this step */
};

extern const nsdae_stepping nsdae_stepping_implicit, nsdae_stepping_printed, nsdae_stepping_moreau,
    nsdae_stepping_penalty, nsdae_stepping_event;

/* NULL past the last; the order is that of enum nsdae_method. */
const nsdae_stepping *nsdae_stepping_of(int method);

/* Sets the sizes, then takes the arrays; system, options and error are set before. */
void nsdae_stepper_prepare(nsdae_stepper *stepper);
void nsdae_stepper_layout(nsdae_stepper *stepper, nsdae_arena *arena);

/* The parts that methods share. */

/* Factors [M Phi_q^T; Phi_q 0] with the given M and Phi_q of the terms; keeps the rank. */
int nsdae_stepper_factor(nsdae_stepper *stepper, nsdae_terms *terms, const double *M);

/* v := the velocity and impulse := the bilateral impulses that momentum r [nv] leads to with the
 * closed contacts of the terms' point:  M v + Phi_q^T Lambda = r + W Lambda_c,  Phi_q v = -Phi_t.
 */
int nsdae_stepper_impact(nsdae_stepper *stepper, const nsdae_terms *terms, const double *r,
                         double *v);

/* dq/dt, with the callback's failure as a status. */
int nsdae_stepper_kinematics(nsdae_stepper *stepper, double t, const double *q, const double *v,
                             double *qdot);

/* r [nv] := M v + h F. */
void nsdae_stepper_momentum(const double *M, const double *v, double h, const double *F, int nv,
                            double *r);

#endif
