#include "newmark.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "system_impl.h"
#include "vector.h"

enum {
  NEWMARK_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                  NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA
};

void nsdae_newmark_layout(nsdae_newmark *newmark, nsdae_arena *arena)
{
  const nsdae_dims *dims = &newmark->system->dims;
  nsdae_arena_doubles(arena, dims->nv, (double **[]){&newmark->a1, &newmark->v, NULL});
  newmark->lambda1 = NSDAE_ARENA_DOUBLES(arena, dims->m);
  nsdae_arena_doubles(arena, dims->nq,
                      (double **[]){&newmark->q, &newmark->qdot0, &newmark->qdot1, NULL});
}

/* a and lambda at the terms' point. The stabilisation is stiff: with s = alpha h + beta^2 h^2/4,
 * the share of a in 2 alpha Phi' + beta^2 Phi, the right-hand side R of Phi_q a = R is replaced
 * by (R + s Phi_q a_last) / (1 + s). It has the same solution, and alpha and beta no longer
 * bound h. a holds a_last on entry where s > 0. */
static int acceleration(nsdae_newmark *N, nsdae_terms *T, double s, double *a, double *lambda)
{
  const nsdae_blocks *blocks = &N->system->blocks;
  double alpha = N->options->baumgarte_alpha, beta = N->options->baumgarte_beta;
  int status = nsdae_terms_need(T, NEWMARK_TERMS);
  if (status < 0) return status;
  for (int i = 0; i < N->system->dims.m; i++) {
    double rate = nsdae_rows_add_dot(blocks, &T->by.jacobian, i, T->v, T->constraint.phi_t[i]);
    double last = nsdae_rows_dot(blocks, &T->by.jacobian, i, a);
    double target = -T->constraint.omega[i] - 2 * alpha * rate - beta * beta * T->constraint.phi[i];
    lambda[i] = s > 0 ? (target + s * last) / (1 + s) : target;
  }
  return N->solve(N->of, T, T->F, a, lambda);
}

/* Iterates on a1; the terms of the last iterate are those of end, with its acceleration in a1. */
static int iterate(nsdae_newmark *N, const nsdae_terms *start, nsdae_terms *end, double t_end,
                   double h)
{
  const nsdae_dims *dims = &N->system->dims;
  double alpha = N->options->baumgarte_alpha, beta = N->options->baumgarte_beta;
  double s = alpha * h + beta * beta * h * h / 4, moved = INFINITY;
  for (N->iterations = 1; N->iterations <= N->options->iteration_max; N->iterations++) {
    /* q1 and v1 of a0 and a1 into N->q, N->v. With dq/dt = H v the positions take the mean of both
     * ends, that of q1 at a point near it; for H = 1 that is h v0 + h^2/4 (a0 + a1). */
    const nsdae_terms *near = N->iterations == 1 ? start : end;
    for (int i = 0; i < dims->nv; i++) N->v[i] = start->v[i] + h / 2 * (N->a0[i] + N->a1[i]);
    int status = nsdae_kinematics_at(near, N->v, N->qdot1);
    for (int i = 0; i < dims->nq; i++) N->q[i] = start->q[i] + h / 2 * (N->qdot0[i] + N->qdot1[i]);
    if (status < 0) return status;
    if (N->iterations > 1)
      moved = nsdae_relative_change(dims->nq, N->q, end->q) +
              nsdae_relative_change(dims->nv, N->v, end->v);
    if (moved <= N->tol) return NSDAE_OK;
    nsdae_terms_at(end, t_end, N->q, N->v);
    status = acceleration(N, end, s, N->a1, N->lambda1);
    if (status < 0) return status;
  }
  nsdae_error_set(N->error, NSDAE_E_CONVERGENCE, "nsdae_newmark", "dt",
                  "the smooth step from t = %.17g did not converge in %d iterations (change %.3g, "
                  "wanted %.3g): make dt smaller",
                  nsdae_system_time(N->system, start->t), N->options->iteration_max, moved, N->tol);
  return nsdae_error_at(N->error, NSDAE_E_CONVERGENCE, -1, nsdae_system_time(N->system, start->t));
}

int nsdae_newmark_step(nsdae_newmark *N, nsdae_terms *start, nsdae_terms *end, double t_end,
                       double h, double *multiplier)
{
  const nsdae_dims *dims = &N->system->dims;
  int status = nsdae_kinematics_at(start, start->v, N->qdot0);
  if (status == NSDAE_OK && !N->have_start) status = acceleration(N, start, 0, N->a0, N->lambda0);
  N->have_start = 0;
  if (status < 0) return status;
  memcpy(N->a1, N->a0, (size_t)dims->nv * sizeof *N->a1);
  status = iterate(N, start, end, t_end, h);
  if (status < 0) return status;
  for (int i = 0; i < dims->m; i++) multiplier[i] = (N->lambda0[i] + N->lambda1[i]) / 2;
  memcpy(N->a0, N->a1, (size_t)dims->nv * sizeof *N->a0);
  memcpy(N->lambda0, N->lambda1, (size_t)dims->m * sizeof *N->lambda0);
  N->have_start = 1;
  return NSDAE_OK;
}
