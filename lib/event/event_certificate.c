/* The laws of contact that a record must fulfil. With h its length, no contact pulls and no
 * friction leaves its cone:
 *
 *   P_N >= -tol,   |P_T| <= mu P_N + tol_T,
 *   tol = e + m u,   tol_T = (nt^1/2 + mu) e + m u,   e = 10 ((n + 2) rtol P + atol h)
 *
 * e is the error of an impulse, so that |P_T| has nt^1/2 e and mu P_N has mu e.
 * The integrator bounds the error of an impulse by 10 rtol P in each step, however short it is
 * (runge_kutta.c): P = dt f, with f the largest of the forces and of M |v| / dt. n steps begin in
 * the record, one before it, and the last one ends after it. A force is zero up to
 * 10 (rtol max |F| + atol). u is the tolerance of velocities and m the mass of the contact, bounded
 * from above by inertia(). The end of an accumulation is ahead of its forces by accumulation_time
 * at most. Within BROUGHT_BACK tolerances no gap is below zero, none of a closed contact is above
 * it (complementarity), and independent constraints and their rates are zero. */
#include "event_method.h"

#include <math.h>

#include "errors.h"

/* In tolerances of a position or velocity. The drift until the next step is projected from 10 on.
 */
static const double BROUGHT_BACK = 100;

static int refuse(const nsdae_event_setting *s, int kind, int item, const char *what, double value,
                  double bound)
{
  char called[NSDAE_CALLED_SIZE];
  double t = nsdae_terms_time(&s->result->end);
  nsdae_error_set(s->error, NSDAE_E_CONVERGENCE, "nsdae_event", "rtol",
                  "%s %s %.3g up to t = %g, above the bound for rtol = %g (%.3g): %smake rtol "
                  "smaller, or use method = implicit",
                  nsdae_system_called(s->system, kind, item, called), what, value, t,
                  s->options->rtol, bound,
                  kind == NSDAE_NAME_CONSTRAINT ? "check omega and f'' of drives, " : "");
  s->error->index = nsdae_system_index(s->system, kind, item);
  s->error->time = t;
  return NSDAE_E_CONVERGENCE;
}

/* Of contact i, an upper bound of 1 / (W^T M^-1 W): W^T M^-1 W is the largest (W^T x)^2 / x^T M x,
 * so that it is W_j^2 / M_jj or more for each j. */
static double inertia(const nsdae_terms *T, int i)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  const nsdae_rows *rows = &T->by.normal;
  double least = INFINITY;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    size_t n = (size_t)nsdae_blocks_size(blocks, rows->block[p]);
    const double *W = rows->value + rows->at[p], *M = T->M + blocks->square[rows->block[p]];
    for (size_t j = 0; j < n; j++)
      if (W[j * rows->stride] != 0)
        least = fmin(least, M[j * (n + 1)] / (W[j * rows->stride] * W[j * rows->stride]));
  }
  return isfinite(least) ? least : 0;
}

/* Whether an accumulation was closed at the end of the record, ahead of its forces. */
static int ends_ahead(const nsdae_event_setting *s)
{
  const nsdae_result *r = s->result;
  double since = nsdae_terms_time(&r->end) - s->options->accumulation_time;
  int any = 0;
  for (int i = 0; i < r->impacts; i++)
    any |= r->impact[i].accumulation && r->impact[i].time >= since;
  return any;
}

/* M |v| of the record's end and start, by the largest entries, as the integrator has it. */
static double momentum_size(const nsdae_terms *T, const double *before)
{
  const nsdae_blocks *b = &T->system->blocks;
  int n = T->system->dims.nv;
  return nsdae_largest((int)b->square[b->count], T->M) *
         fmax(nsdae_largest(n, T->v), nsdae_largest(n, before));
}

static int check_impulses(const nsdae_event_phase *phase, const nsdae_terms *from)
{
  const nsdae_event_setting *s = phase->setting;
  const nsdae_result *r = s->result;
  const nsdae_impulses *p = &r->impulses;
  const nsdae_sim_options *o = s->options;
  int k = s->system->dims.k, nt = s->system->dims.nt;
  double h = r->end.t - from->t;
  double most = fmax(nsdae_largest(k, p->normal), nsdae_largest(k * nt, p->tangential));
  double force = nsdae_largest(s->system->dims.nv, r->end.F);
  double early = ends_ahead(s) ? fmin(1, o->accumulation_time / h) * fmax(most, h * force) : 0;
  most = fmax(most, fmax(o->dt * force, momentum_size(&r->end, from->v)));
  double steps = (double)(r->counters.iterations + 2), slow = nsdae_event_velocity_size(s);
  double all = 10 * (steps * o->rtol * most + o->atol * h) + early;
  for (int i = 0; i < k; i++) {
    double mu = s->system->contact[i].mu, tol = all + inertia(&r->end, i) * slow;
    double along = nsdae_norm(nt, p->tangential + i * nt);
    if (-p->normal[i] > tol)
      return refuse(s, NSDAE_NAME_CONTACT, i, "has the adhesive impulse", p->normal[i], -tol);
    double excess = along - mu * p->normal[i];
    tol += (sqrt(nt) + mu - 1) * all;
    tol *= phase->modes.blur[i]; /* friction that chatters has a larger tolerance */
    if (excess > tol)
      return refuse(s, NSDAE_NAME_CONTACT, i, "has friction outside its cone, by the impulse",
                    excess, tol);
  }
  return NSDAE_OK;
}

static int any_impulse(const nsdae_result *r, const nsdae_dims *d)
{
  return nsdae_largest(d->k, r->impulses.normal) > 0 ||
         nsdae_largest(d->k * d->nt, r->impulses.tangential) > 0;
}

/* How deep contact i was at the start of the step, as a step by implicit may leave it. */
static double depth_before(const nsdae_terms *from, int i)
{
  return from->have & NSDAE_TERM_GAP ? fmax(0, -from->gap[i]) : 0;
}

int nsdae_event_certify(const nsdae_event_phase *phase, const nsdae_terms *from)
{
  const nsdae_event_setting *s = phase->setting;
  nsdae_terms *T = &s->result->end; /* of the record, which needs most of it, too */
  const nsdae_dims *d = &s->system->dims;
  unsigned impulses =
      any_impulse(s->result, d) ? NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_NORMAL : 0u;
  unsigned rates = d->m > 0 ? NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T : 0u;
  int status = nsdae_terms_need(T, impulses | rates | NSDAE_TERM_PHI | NSDAE_TERM_GAP);
  if (status == NSDAE_OK && impulses) status = check_impulses(phase, from);
  if (status < 0) return status;
  double tol = BROUGHT_BACK * nsdae_event_position_size(s);
  for (int i = 0; i < d->k; i++) {
    double before = depth_before(from, i); /* within tol no depth makes room for more */
    double bound = before > tol ? before + tol : tol;
    if (-T->gap[i] > bound)
      return refuse(s, NSDAE_NAME_CONTACT, i, "overlaps by", -T->gap[i], bound);
    if (s->result->impulses.mode[i] != NSDAE_MODE_OPEN && T->gap[i] > tol)
      return refuse(s, NSDAE_NAME_CONTACT, i, "is closed and has the gap", T->gap[i], tol);
  }
  double fast = BROUGHT_BACK * nsdae_event_velocity_size(s);
  for (int i = 0; i < d->m && !*phase->modes.redundant; i++) {
    double phi = T->constraint.phi[i], rate = nsdae_terms_constraint_rate(T, i, T->v);
    if (fabs(phi) > tol) return refuse(s, NSDAE_NAME_CONSTRAINT, i, "is violated by", phi, tol);
    if (fabs(rate) > fast) return refuse(s, NSDAE_NAME_CONSTRAINT, i, "has the rate", rate, fast);
  }
  return NSDAE_OK;
}
