/* A start is taken as far as it was meant: with the relative error tol = start_tol of its numbers a
 * row has the error tol |row|_1 max |x|, of its coordinates for a position and of its velocities
 * for a velocity. The 1 stands for constants of order one that are not seen in the row. So
 *
 *   |Phi_i|, -g_N,i        <= tol (1 + |Phi_q,i|_1 max |q|),   tol (1 + |W_N,i|_1 max |q|)
 *   |Phi_q v + Phi_t|_i    <= tol (1 + |Phi_q,i|_1 max |v| + |Phi_t,i|)
 *   | |q_unit| - 1 |       <= tol
 *
 * tol = 1e-6 takes numbers of six digits. The overlap of penalty's contacts is how they press:
 * there it is no error. */
#include "start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "sim_impl.h"
#include "system_impl.h"
#include "vector.h"

static double largest(const double *a, int n)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i]));
  return most;
}

static double row_sum(const double *a, int n, size_t stride)
{
  double sum = 0;
  for (int j = 0; j < n; j++) sum += fabs(a[(size_t)j * stride]);
  return sum;
}

static int refuse(const nsdae_terms *T, const char *argument, int kind, int i, const char *what,
                  double value, double bound)
{
  char called[NSDAE_CALLED_SIZE];
  nsdae_error_set(T->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", argument,
                  "%s %s %.6g at the start: it must be at most %.3g (see start_tol); "
                  "nsdae_sim_project puts a start right",
                  nsdae_system_called(T->system, kind, i, called), what, value, bound);
  T->error->index = i;
  T->error->time = T->t;
  return NSDAE_E_ARGUMENT;
}

static int check_constraints(const nsdae_terms *T, double tol)
{
  const nsdae_dims *d = &T->system->dims;
  double q = largest(T->q, d->nq), v = largest(T->v, d->nv);
  for (int i = 0; i < d->m; i++) {
    double sum = row_sum(T->J + i, d->nv, (size_t)d->m), bound = tol * (1 + sum * q);
    if (fabs(T->phi[i]) > bound)
      return refuse(T, "q0", NSDAE_NAME_CONSTRAINT, i, "is off by", fabs(T->phi[i]), bound);
    double rate = T->phi_t[i];
    for (int j = 0; j < d->nv; j++) rate += T->J[(size_t)j * (size_t)d->m + (size_t)i] * T->v[j];
    bound = tol * (1 + sum * v + fabs(T->phi_t[i]));
    if (fabs(rate) > bound)
      return refuse(T, "v0", NSDAE_NAME_CONSTRAINT, i, "is violated at the rate", fabs(rate),
                    bound);
  }
  return NSDAE_OK;
}

static int check_gaps(const nsdae_terms *T, double tol)
{
  const nsdae_dims *d = &T->system->dims;
  double q = largest(T->q, d->nq);
  for (int i = 0; i < d->k; i++) {
    double bound = tol * (1 + q * row_sum(T->W_N + (size_t)i * (size_t)d->nv, d->nv, 1));
    if (-T->gap[i] > bound)
      return refuse(T, "q0", NSDAE_NAME_CONTACT, i, "overlaps by", -T->gap[i], bound);
  }
  return NSDAE_OK;
}

/* A quaternion has length one; two coordinates may as well be a point on a circle. */
static int is_rotation(const nsdae_units *u, int nq, int group)
{
  int size = 0;
  for (int i = 0; i < nq; i++) size += u->of[i] == group;
  return size == 4 || fabs(u->length[group] - 1) < 0.1;
}

static int check_units(const nsdae_projector *p, const nsdae_terms *T, double tol)
{
  int nq = T->system->dims.nq;
  for (int g = 0; g < p->units.count; g++) {
    int first = 0;
    while (p->units.of[first] != g) first++;
    double off = fabs(p->units.length[g] - 1);
    if (off > tol && is_rotation(&p->units, nq, g))
      return refuse(T, "q0", NSDAE_NAME_COORDINATE, first,
                    "begins a group of unit length (dq/dt shows it) whose length is off by", off,
                    tol);
  }
  return NSDAE_OK;
}

int nsdae_start_check(const nsdae_projector *p, const nsdae_terms *T)
{
  const nsdae_sim_options *o = p->tools->options;
  int status = check_units(p, T, o->start_tol);
  if (status == NSDAE_OK) status = check_constraints(T, o->start_tol);
  if (status == NSDAE_OK && o->method != NSDAE_METHOD_PENALTY) status = check_gaps(T, o->start_tol);
  return status;
}

/* ---- putting one right, beside the state of the simulation */

typedef struct bench {
  nsdae_terms terms;
  nsdae_projector projection;
  nsdae_evals evals;
} bench;

static void layout(void *object, nsdae_arena *arena)
{
  bench *b = object;
  nsdae_terms_layout(&b->terms, arena);
  nsdae_projector_layout(&b->projection, arena);
}

static void aim_at_unit_length(nsdae_projector *p, int nq)
{
  for (int g = 0; g < p->units.count; g++)
    if (is_rotation(&p->units, nq, g)) p->units.length[g] = 1;
}

static int put_right(bench *b, double t0, double *q0, double *v0)
{
  const nsdae_dims *d = &b->terms.system->dims;
  nsdae_terms_at(&b->terms, t0, q0, v0);
  nsdae_units_find(&b->projection, t0, q0);
  aim_at_unit_length(&b->projection, d->nq);
  int status = nsdae_project_positions(&b->projection, &b->terms, 1);
  if (status == NSDAE_OK) status = nsdae_project_velocities(&b->projection, &b->terms);
  if (status < 0) return status;
  memcpy(q0, b->terms.q, (size_t)d->nq * sizeof *q0);
  memcpy(v0, b->terms.v, (size_t)d->nv * sizeof *v0);
  return NSDAE_OK;
}

int nsdae_sim_project(nsdae_sim *sim, double t0, double *q0, double *v0)
{
  if (!sim) return NSDAE_E_ARGUMENT;
  if (nsdae_observers_quiet(sim, "nsdae_sim_project") < 0) return NSDAE_E_STATE;
  nsdae_error_clear(&sim->error);
  int status = nsdae_sim_check_state(sim, "nsdae_sim_project", t0, q0, v0);
  if (status < 0) return status;
  bench b = {.evals = {0}};
  nsdae_arena arena;
  nsdae_stepper_prepare_terms(&sim->stepper, &b.terms);
  b.terms.evals = &b.evals;
  b.projection.tools = &sim->stepper;
  b.projection.rows_most = sim->system->dims.m + sim->system->dims.k;
  if (nsdae_arena_build(&arena, layout, &b) < 0)
    return nsdae_error_set(&sim->error, NSDAE_E_MEMORY, "nsdae_sim_project", "", "out of memory");
  status = put_right(&b, t0, q0, v0);
  nsdae_arena_release(&arena);
  return status;
}
