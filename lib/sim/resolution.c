/* What doubles and tolerances cannot resolve is refused at the start.
 *
 * Time. The user's times near t0 are r = eps |t0| apart, or less: a shorter dt gives two steps the
 * same time. Callbacks that depend on t see r / 2 as noise: a method with rtol takes gaps that
 * differ by less than 10 rtol of the way of a step (position_tolerance) for equal, so that
 * r / 2 <= 10 rtol dt.
 *
 * Length. A row (gap or constraint) whose way in a step is less than its tolerance has a velocity
 * that is zero to the method. It passes its lengths sum_j |W_ij q_j| unseen within a hundred steps
 * where the tolerance is more than a hundredth of them: atol, or rtol of the rotations, is no
 * measure of the bodies. */
#include <float.h>
#include <math.h>

#include "errors.h"
#include "sim_impl.h"

static const double NOISE = 2 * 10;     /* rtol dt: r at most */
static const double OWN_LENGTHS = 0.01; /* of a row */

enum { SEEN = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_GAP };

static int has_tolerance(const nsdae_sim_options *o)
{
  return o->method == NSDAE_METHOD_EVENT || o->method == NSDAE_METHOD_PENALTY;
}

static int differ(const double *a, const double *b, int n)
{
  for (int i = 0; i < n; i++)
    if (a[i] != b[i]) return 1;
  return 0;
}

/* Whether a term is another one a step later at the same place. A callback that has no value there
 * does not count. */
static int depends_on_time(nsdae_sim *sim, const nsdae_terms *start)
{
  const nsdae_dims *d = &start->system->dims;
  nsdae_terms *later = &sim->stepper.middle;
  nsdae_terms_at(later, sim->options.dt, start->q, start->v);
  int status = nsdae_terms_need(later, SEEN);
  nsdae_error_clear(&sim->error);
  return status == NSDAE_OK &&
         (differ(start->F, later->F, d->nv) || differ(start->M, later->M, d->nv * d->nv) ||
          differ(start->constraint.phi, later->constraint.phi, d->m) ||
          differ(start->gap, later->gap, d->k));
}

static int check_time(nsdae_sim *sim, const nsdae_terms *start)
{
  const nsdae_sim_options *o = &sim->options;
  double t0 = nsdae_terms_time(start), apart = DBL_EPSILON * fabs(t0);
  if (!(o->dt >= apart))
    return nsdae_error_set(
        &sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", "dt",
        "dt = %g is lost in rounding at t0 = %.17g: it must be at least %.2g, or "
        "time be counted from nearer the start",
        o->dt, t0, apart);
  if (!has_tolerance(o) || apart <= NOISE * o->rtol * o->dt || !depends_on_time(sim, start))
    return NSDAE_OK;
  return nsdae_error_set(
      &sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", "t0",
      "t0 = %.17g: times there are %.2g apart, callbacks depend on t, and rtol dt "
      "= %.2g must be at least %.2g: count time from nearer the start, or take a "
      "larger rtol",
      t0, apart, o->rtol * o->dt, apart / NOISE);
}

/* Amounts of a row's terms: of its lengths, and of its way in a step h. */
static double lengths_of(const nsdae_terms *T, const nsdae_rows *rows, int i, double h, double *way)
{
  const double *W = rows->value + rows->at[rows->first[i]];
  int n = T->system->dims.nv, plain = T->system->dims.nq == n;
  double lengths = 0;
  *way = 0;
  for (int j = 0; j < n; j++) {
    double w = fabs(W[(size_t)j * rows->stride]), inertia = T->M[(size_t)j * (size_t)(n + 1)];
    lengths += w * (plain ? fabs(T->q[j]) : nsdae_largest(T->system->dims.nq, T->q));
    *way += w * h * (fabs(T->v[j]) + h * fabs(T->F[j]) / inertia);
  }
  return lengths;
}

/* Ten errors of a position, as the integrators control them far from the origin (runge_kutta.h). */
static double position_tolerance(const nsdae_sim_options *o, const nsdae_terms *T)
{
  return 10 * (o->rtol * o->dt * nsdae_largest(T->system->dims.nv, T->v) + o->atol);
}

static int check_rows(nsdae_sim *sim, const nsdae_terms *T, const nsdae_rows *rows, int kind)
{
  const nsdae_sim_options *o = &sim->options;
  double tol = position_tolerance(o, T), way;
  char called[NSDAE_CALLED_SIZE];
  for (int i = 0; i < rows->count; i++) {
    double lengths = lengths_of(T, rows, i, o->dt, &way);
    if (!(way > 0 && lengths > 0)) continue; /* at rest; at the origin: nothing is known */
    if (tol <= way || tol <= OWN_LENGTHS * lengths) continue;
    nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", "atol",
                    "%s has lengths of %.2g and goes %.2g in a step, and atol = %g and rtol = %g "
                    "resolve %.2g: take a unit of length near the size of the bodies, or a smaller "
                    "atol",
                    nsdae_system_called(T->system, kind, i, called), lengths, way, o->atol, o->rtol,
                    tol);
    sim->error.index = i;
    return NSDAE_E_ARGUMENT;
  }
  return NSDAE_OK;
}

int nsdae_start_resolved(nsdae_sim *sim, const nsdae_terms *start)
{
  int status = check_time(sim, start);
  if (status < 0 || !has_tolerance(&sim->options)) return status;
  status = check_rows(sim, start, &start->by.normal, NSDAE_NAME_CONTACT);
  if (status == NSDAE_OK)
    status = check_rows(sim, start, &start->by.jacobian, NSDAE_NAME_CONSTRAINT);
  return status;
}
