/* What the parts of an instant share: see event_instant.c. The terms are those of the instant. */
#ifndef NSDAE_EVENT_INSTANT_H
#define NSDAE_EVENT_INSTANT_H

#include "event.h"
#include "vector.h"

enum {
  NSDAE_EVENT_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                      NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA | NSDAE_TERM_GAP | NSDAE_TERM_NORMAL |
                      NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE |
                      NSDAE_TERM_ACCELERATION
};

static inline nsdae_terms *nsdae_event_here(const nsdae_event_method *e)
{
  return &e->stepper->middle;
}

static inline double nsdae_event_normal_velocity(const nsdae_terms *T, int i, const double *v)
{
  int n = T->system->dims.nv;
  return nsdae_dot(n, T->W_N + (size_t)(i * n), v) + T->w_N[i];
}

/* The j-th tangential velocity of all. */
static inline double nsdae_event_tangential_velocity(const nsdae_terms *T, int j, const double *v)
{
  int n = T->system->dims.nv;
  return nsdae_dot(n, T->W_T + (size_t)(j * n), v) + T->w_T[j];
}

/* Whether friction can move contact or slide in this column of the problem at all. */
static inline int nsdae_event_powerless(const nsdae_contacts *c, int column)
{
  return c->delassus.G[(size_t)column * (size_t)(c->columns + 1)] == 0;
}

/* Projections: q of y to the constraints and the gaps of the candidates; v of y to the rates of the
 * constraints, of what is closed and of what sticks. A status of the factorisation or a callback.
 */
int nsdae_event_project_positions(nsdae_event_method *e, double t);
int nsdae_event_project_velocities(nsdae_event_method *e);

/* Impacts of what touches and approaches, until nothing does; *any is set where there was one. */
int nsdae_event_impacts(nsdae_event_method *e, double t, int *any);
/* Whether contact i touches but for the integrator's error, and does not part. */
int nsdae_event_touches(const nsdae_event_method *e, int i);

/* Laws of the candidates; right after an impact (impacted) none is known to have stopped. */
void nsdae_event_set_laws(nsdae_event_method *e, int impacted);
/* Accelerations and forces of the candidates under their laws; into e->a, e->lambda, e->modes. A
 * paradox at t is NSDAE_E_PAINLEVE with the record. */
int nsdae_event_accelerate(nsdae_event_method *e, double t);
/* What counts as zero for an acceleration. */
double nsdae_event_acceleration_size(const nsdae_event_method *e);

/* The modes of all, and their accelerations and forces. */
int nsdae_event_find_modes(nsdae_event_method *e, double t, int impacted);
/* direction [nt] := -force / |force|, or 0. */
void nsdae_event_point_against(double *direction, int nt, const double *force);
/* Which rows of the modes are independent, and what the others have in their place, from the
 * solution in e->modes, e->lambda; the forces there may be shared differently afterwards. NSDAE_OK
 * or NSDAE_E_CONVERGENCE with the record. */
int nsdae_event_find_rows(nsdae_event_method *e, double t);
/* The solution in e->modes, e->a, e->lambda with friction cones in place of polygons, where there
 * are no slides; 1 when it was found, else they are as before. */
int nsdae_event_solve_cones(nsdae_event_method *e);
/* A contact at rest whose friction is all used, and which does not begin to slide, sticks. */
void nsdae_event_hold_resting(nsdae_event_method *e);

#endif
