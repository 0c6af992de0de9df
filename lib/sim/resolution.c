/* Scales of a start: those that warnings are held against (monitors.c), and what doubles and
 * tolerances cannot resolve, which is refused.
 *
 * Time. The user's times near t0 are r = eps |t0| apart, or less: a shorter dt gives two steps the
 * same time. Callbacks that depend on t see r / 2 as noise: a method with rtol takes gaps that
 * differ by less than 10 rtol of the way of a step (position_tolerance) for equal, so that
 * r / 2 <= 10 rtol dt.
 *
 * Length. A row (gap or constraint) whose way in a step is less than its tolerance has a velocity
 * that is zero to the method. It passes its lengths unseen within a hundred steps where the
 * tolerance is more than a hundredth of them: atol, or rtol of the rotations, is no measure of the
 * bodies. They are the largest of sum_j |W_ij q_j|, |g_i| and the size of its bodies, if one is
 * given: the sum alone is rounding where a body starts beside the origin. Where the sum is no more
 * than that of the other coordinates, and no size is given, nothing is known. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "errors.h"
#include "sim_impl.h"
#include "vector.h"

static const double NOISE = 2 * 10;     /* rtol dt: r at most */
static const double OWN_LENGTHS = 0.01; /* of a row */

enum { SEEN = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_GAP };

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
  const nsdae_blocks *blocks = &start->system->blocks;
  size_t squares = blocks->square[blocks->count];
  nsdae_terms *later = &sim->stepper.middle;
  nsdae_terms_at(later, sim->options.dt, start->q, start->v);
  int status = nsdae_terms_need(later, SEEN);
  nsdae_error_clear(&sim->error);
  return status == NSDAE_OK &&
         (differ(start->F, later->F, d->nv) || differ(start->M, later->M, (int)squares) ||
          differ(start->constraint.phi, later->constraint.phi, d->m) ||
          differ(start->gap, later->gap, d->k));
}

/* Amounts of a row's terms: of its lengths, and of its way in a step h. */
static double lengths_of(const nsdae_terms *T, const nsdae_rows *rows, int i, double h, double *way)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  int plain = T->system->dims.nq == T->system->dims.nv;
  double lengths = 0, largest = nsdae_largest(T->system->dims.nq, T->q);
  *way = 0;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p], first = blocks->first[b], n = nsdae_blocks_size(blocks, b);
    const double *W = rows->value + rows->at[p], *M = T->M + blocks->square[b];
    for (int j = 0; j < n; j++) {
      double w = fabs(W[(size_t)j * rows->stride]), inertia = M[(size_t)j * (size_t)(n + 1)];
      lengths += w * (plain ? fabs(T->q[first + j]) : largest);
      *way += w * h * (fabs(T->v[first + j]) + h * fabs(T->F[first + j]) / inertia);
    }
  }
  return lengths;
}

static int check_rows(nsdae_sim *sim, const nsdae_terms *T, const nsdae_rows *rows, int kind)
{
  const nsdae_sim_options *o = &sim->options;
  /* ten errors of a position, as the integrators control them far from the origin (runge_kutta.h)
   */
  double tol = 10 * (o->rtol * o->dt * nsdae_largest(T->system->dims.nv, T->v) + o->atol), way;
  double rounding = DBL_EPSILON * nsdae_largest(T->system->dims.nq, T->q);
  const double *arm = T->system->size[NSDAE_NAME_CONSTRAINT];
  char called[NSDAE_CALLED_SIZE];
  for (int i = 0; i < rows->count; i++) {
    double lengths = lengths_of(T, rows, i, o->dt, &way);
    double size = kind == NSDAE_NAME_CONTACT ? nsdae_contact_size(T->system, i) : arm ? arm[i] : 0;
    if (!(way > 0 && (lengths > rounding || size > 0))) continue; /* at rest; nothing is known */
    lengths = fmax(lengths, size);
    if (kind == NSDAE_NAME_CONTACT) lengths = fmax(lengths, fabs(T->gap[i]));
    if (tol <= way || tol <= OWN_LENGTHS * lengths) continue;
    nsdae_error_set(
        &sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", "atol",
        "%s has lengths of %.2g and moves by %.2g in a step; atol = %g and rtol = %g resolve %.2g: "
        "use a unit of length near the size of the bodies, or a smaller atol",
        nsdae_system_called(T->system, kind, i, called), lengths, way, o->atol, o->rtol, tol);
    return nsdae_error_at(&sim->error, NSDAE_E_ARGUMENT, nsdae_system_index(T->system, kind, i),
                          NAN);
  }
  return NSDAE_OK;
}

int nsdae_start_resolved(nsdae_sim *sim, const nsdae_terms *start)
{
  const nsdae_sim_options *o = &sim->options;
  double t0 = nsdae_terms_time(start), apart = DBL_EPSILON * fabs(t0);
  if (!(o->dt >= apart))
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", "dt",
                           "dt = %g is lost in rounding at t0 = %.17g: it must be at least %.2g; a "
                           "smaller t0 allows smaller steps",
                           o->dt, t0, apart);
  if (o->method != NSDAE_METHOD_EVENT && o->method != NSDAE_METHOD_PENALTY) return NSDAE_OK;
  if (apart > NOISE * o->rtol * o->dt && depends_on_time(sim, start))
    return nsdae_error_set(
        &sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", "t0",
        "t0 = %.17g: times have a spacing of %.2g, callbacks depend on t, and "
        "rtol dt = %.2g must be at least %.2g: use a smaller t0, or a larger rtol",
        t0, apart, o->rtol * o->dt, apart / NOISE);
  int status = check_rows(sim, start, &start->by.normal, NSDAE_NAME_CONTACT);
  if (status == NSDAE_OK)
    status = check_rows(sim, start, &start->by.jacobian, NSDAE_NAME_CONSTRAINT);
  return status;
}

static double largest_entry(const nsdae_blocks *blocks, const nsdae_rows *rows)
{
  double most = 0;
  for (int i = 0; i < rows->count; i++) most = fmax(most, nsdae_rows_largest(blocks, rows, i));
  return most;
}

/* The largest gap, if start_tol does not make it none; else 0, as of penalty, whose stiffness gives
 * the depth. */
static double apart(const nsdae_terms *start, const nsdae_sim_options *o)
{
  double most = 0, start_tol = o->start_tol;
  if (o->method == NSDAE_METHOD_PENALTY) return 0;
  for (int i = 0; i < start->system->dims.k; i++)
    if (start->gap[i] < NSDAE_FAR) most = fmax(most, start->gap[i]);
  return most > start_tol * (1 + nsdae_largest(start->system->dims.nq, start->q)) ? most : 0;
}

/* What the forces F lead to in a step from rest: the way h^2 F / M, and the rounding of the kinetic
 * energy. What is held has none of it, and is not told of that. */
static double way_from_rest(const nsdae_terms *T, const double *F, double h, double *rounding)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  double rows = fmax(largest_entry(blocks, &T->by.jacobian), largest_entry(blocks, &T->by.normal));
  double most = 0, sum = 0;
  for (int b = 0; b < blocks->count; b++) {
    size_t n = (size_t)nsdae_blocks_size(blocks, b);
    const double *f = F + blocks->first[b], *M = T->M + blocks->square[b];
    for (size_t j = 0; j < n; j++) {
      most = fmax(most, fabs(f[j]) / M[j * (n + 1)]);
      sum += f[j] * f[j] / M[j * (n + 1)];
    }
  }
  *rounding = DBL_EPSILON * h * h * sum / 2;
  return h * h * rows * most;
}

int nsdae_monitors_start(const nsdae_sim *sim, nsdae_point *point)
{
  const nsdae_terms *start = &point->result.end;
  const nsdae_dims *d = &start->system->dims;
  double *still = sim->probe, *F = still + d->nv, h = sim->options.dt;
  size_t size = (size_t)d->nv * sizeof *F;
  /* The forces at the start's place with v = 0: a damper that brakes what is fast leads nothing
   * that rests anywhere. What is not defined there is as it is at the start. */
  memcpy(F, start->F, size);
  if (nsdae_largest(d->nv, start->v) > 0) {
    double t = nsdae_terms_time(start);
    memset(still, 0, size);
    memset(F, 0, size);
    int code = start->system->call.force(t, start->q, still, F, start->system->user);
    if (code) return nsdae_system_callback_status(code, "force", t, start->error);
    for (int i = 0; i < d->nv; i++)
      if (!isfinite(F[i])) F[i] = start->F[i];
  }
  double rounding, from_rest = way_from_rest(start, F, h, &rounding);
  double row = largest_entry(&start->system->blocks, &start->by.jacobian);
  point->accounts.watch = (nsdae_monitors){.change = from_rest,
                                           .row = row,
                                           .way = fmax(from_rest, row * nsdae_terms_touch(start)),
                                           .apart = apart(start, &sim->options),
                                           .scale = fmax(point->record.kinetic, rounding),
                                           .kinetic = point->record.kinetic,
                                           .known = point->record.kinetic};
  return NSDAE_OK;
}
