/* What every part of the event-driven method stands on: the system, the point in work and the
 * places of the unknowns. The folders, each of which sees only those that it links:
 *   phase     the equations between two instants, for the modes that hold there, and what the
 *             forces do: impulses and work
 *   roots     the functions whose zeros end a phase
 *   modes     those of the next phase, from the problem of accelerations, sharing its dependent
 *             rows
 *   impact    the problem of velocities; impacts without end that come to rest; back to the
 *             constraints and to what is closed
 *   instant   all of these in their order
 *   event     a phase from its start on, and from instant to instant: the method */
#ifndef NSDAE_EVENT_SETTING_H
#define NSDAE_EVENT_SETTING_H

#include "stepper.h"
#include "tracking.h"

/* Slower than this multiple of the velocity tolerance, a contact that opens is closed. */
#define NSDAE_EVENT_SLOW 4

/* The largest relative error of differences, eps^(1/2): beyond it the function is not smooth. */
#define NSDAE_EVENT_DIFFERENCES 1.5e-8

/* Where the unknowns of a phase are in y = [q, v, lambda, F_N, F_T, F_S]; n: its length; whole:
 * that of z, see account.h. */
typedef struct nsdae_event_places {
  int v, lambda, normal, tangential, frictional_joint, n, whole;
} nsdae_event_places;

typedef struct nsdae_event_setting {
  const nsdae_system *system;
  const nsdae_sim_options *options;
  nsdae_error *error;
  nsdae_terms *here; /* at the point in work */
  nsdae_kkt *kkt;    /* of M and Phi_q where they were last factored */
  nsdae_event_places at;
  double error_by_differences[2]; /* of velocities and accelerations along the motion */
  nsdae_result *result;           /* of the step in work */
  nsdae_tracking *tracking;       /* of contacts in slots */
} nsdae_event_setting;

/* Fills `at`; the system is set before. */
void nsdae_event_set_places(nsdae_event_setting *setting);

/* y [n] as the point in work, all terms out of date. */
void nsdae_event_move(nsdae_event_setting *setting, double t, const double *y);

/* Factors M and Phi_q of the point, and keeps what rank was met. */
int nsdae_event_factor(nsdae_event_setting *setting);

/* The residual of a problem that was solved, and its tolerance, are a part of the result's. */
void nsdae_event_add_residual(nsdae_event_setting *setting, const nsdae_contacts *contacts);

/* Solves the problem whose contacts are closed with the terms' W and w, and counts it; the
 * arguments are those of nsdae_contacts_solve. */
int nsdae_event_solve(nsdae_event_setting *setting, nsdae_contacts *contacts,
                      const nsdae_terms *terms, double *size, double *v, double *lambda);

/* The tolerances of positions (relative to the way in a dt: the origin may be anywhere) and
 * for velocities, the integrator's accuracy; and the rounding of a gap, far from the origin. */
double nsdae_event_position_size(const nsdae_event_setting *setting);
double nsdae_event_rounding(const nsdae_event_setting *setting);
double nsdae_event_velocity_size(const nsdae_event_setting *setting);

/* The tolerance of velocities if `most` were the largest; the largest of the bodies of contact i.
 */
double nsdae_event_velocity_size_of(const nsdae_event_setting *setting, double most);
double nsdae_event_own_speed(const nsdae_event_setting *setting, int i);

/* For a warning: contact i was closed with this velocity, though it exceeds the tolerance that the
 * speeds of its bodies give. The first of the step is kept. */
void nsdae_event_unresolved(nsdae_event_setting *setting, int i, double velocity);

/* Everything that an instant asks of its point. */
enum {
  NSDAE_EVENT_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                      NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA | NSDAE_TERM_GAP | NSDAE_TERM_NORMAL |
                      NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE |
                      NSDAE_TERM_ACCELERATION | NSDAE_TERM_BOUND
};

#endif
