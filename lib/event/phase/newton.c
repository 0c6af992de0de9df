/* The equations of a phase in implicit form and Newton's matrix, for IDA: y = [q, v, lambda, F_N,
 * F_T, F_S] and the rows of phase.h,
 *
 *   r_q = q' - H v,   r_v = M v' + Phi_q^T lambda - F - sum_p W_p F_p
 *   r_lambda = Phi_q v' + omega + 2 alpha Phi' + beta^2 Phi
 *   closed:   r_p = W_p^T v' + omega_p + 2 alpha v_p + beta^2 g
 *   sliding:  r_p = F_p + mu F_N d,  or F_p + mu |lambda| s
 *   related:  r_p = F_p - sum_l r_l F_l
 *
 * all but r_q at q* = q - r_q / cj, see ida.h. With dq* = H dv / cj, l = dlambda / cj, phi = dF /
 * cj and c = cj + 2 alpha + beta^2 / cj, and without the change of M, Phi_q and W along the motion,
 * which is small as 1 / cj is:
 *
 *   A dv + Phi_q^T l - W phi = r_v / cj,   Phi_q dv = r_lambda / c,   closed: W_p^T dv = r_p / c
 *   sliding:  phi_p + mu d phi_N + mu F_N / cj d'(v_T) W_T^T dv = r_p / cj,   d' = (1 - d d^T) /
 * |v_T|
 *
 * which border.h solves. */
#include <math.h>
#include <string.h>

#include "phase.h"
#include "stalled_steps.h"

/* ---- the residual */

/* Terms at q*; r_q. */
static int move(nsdae_event_phase *p, double t, const double *y, const double *ydot, double cj,
                double *r)
{
  nsdae_event_setting *s = p->setting;
  double *to = p->moved;
  nsdae_event_move(s, t, y);
  int status = nsdae_kinematics_at(s->here, s->here->v, to);
  for (int i = 0; i < s->at.v; i++) r[i] = ydot[i] - to[i];
  memcpy(to, y, (size_t)s->at.lambda * sizeof *y);
  for (int i = 0; i < s->at.v; i++) to[i] -= r[i] / cj;
  nsdae_event_move(s, t, to);
  return status < 0 ? status : nsdae_terms_need(s->here, p->terms);
}

/* r of a force that follows from others. */
static double following(const nsdae_event_phase *p, const nsdae_event_row *row, const double *y)
{
  const nsdae_system *s = p->setting->system;
  const double *force = y + p->setting->at.normal;
  int k = s->dims.k, nt = s->dims.nt, all = k * (1 + nt), i = row->force;
  double r = force[i], d[2];
  if (row->kind == NSDAE_ROW_RELATED) return r - nsdae_dot(all, p->modes.relation + i * all, force);
  if (row->kind == NSDAE_ROW_SLIDE_RUBS)
    return r + nsdae_event_joint_friction(p, i - all) *
                   y[p->setting->at.lambda + s->frictional_joint[i - all].constraint];
  nsdae_event_sliding_direction(p, (i - k) / nt, d);
  return r + s->contact[(i - k) / nt].mu * d[(i - k) % nt] * force[(i - k) / nt];
}

int nsdae_event_residual(double t, const double *y, const double *ydot, double cj, double *r,
                         nsdae_event_phase *p)
{
  const nsdae_event_places *at = &p->setting->at;
  const nsdae_event_rows *b = &p->rows;
  const nsdae_terms *T = p->setting->here;
  const nsdae_system *s = T->system;
  const nsdae_sim_options *o = p->setting->options;
  const double *lambda = y + at->lambda, *acceleration = ydot + at->v;
  double *v = r + at->v, alpha2 = 2 * o->baumgarte_alpha;
  int status = move(p, t, y, ydot, cj, r);
  if (status < 0) return nsdae_progress_code(status, p->setting->error);
  for (int i = 0; i < s->dims.nv; i++) v[i] = -T->F[i];
  nsdae_blocks_add_product(&s->blocks, T->M, acceleration, v);
  for (int i = 0; i < s->dims.m; i++) {
    nsdae_rows_add(&s->blocks, &T->by.jacobian, i, lambda[i], v);
    r[at->lambda + i] = nsdae_terms_rate(T, &T->by.jacobian, T->constraint.omega, i, acceleration) +
                        alpha2 * nsdae_terms_constraint_rate(T, i, T->v) +
                        o->baumgarte_beta * o->baumgarte_beta * T->constraint.phi[i];
  }
  memcpy(r + at->normal, y + at->normal, (size_t)(at->n - at->normal) * sizeof *r);
  for (int a = 0; a < b->count; a++) {
    const nsdae_event_row *row = &b->row[a];
    nsdae_rows_add(&s->blocks, row->rows, row->index, -y[at->normal + row->force], v);
    r[at->normal + row->force] =
        row->kind == NSDAE_ROW_CLOSED
            ? nsdae_rows_dot(&s->blocks, row->rows, row->index, acceleration) -
                  nsdae_event_wanted(p, row)
            : following(p, row, y);
  }
  return 0;
}

/* ---- Newton's matrix */

int nsdae_event_newton_setup(double t, const double *y, const double *ydot, double cj,
                             nsdae_event_phase *p)
{
  nsdae_event_setting *s = p->setting;
  int redundant = *p->modes.redundant;
  (void)ydot;
  nsdae_event_move(s, t, y);
  int status = nsdae_terms_need(s->here, p->terms);
  if (status == NSDAE_OK)
    status = nsdae_newton_kkt_factor(&p->newton, s->here, cj, redundant ? p->modes.basis : NULL,
                                     s->system->dims.m - redundant);
  if (status == NSDAE_OK) status = nsdae_event_factor_border(p, &p->newton.border, y, cj);
  return nsdae_progress_code(status, s->error);
}

int nsdae_event_newton_solve(double cj, double *r, double *x, nsdae_event_phase *p)
{
  const nsdae_event_setting *s = p->setting;
  const nsdae_event_places *at = &s->at;
  const nsdae_event_rows *b = &p->rows;
  const nsdae_dims *d = &s->system->dims;
  const nsdae_sim_options *o = s->options;
  double alpha2 = 2 * o->baumgarte_alpha, beta2 = o->baumgarte_beta * o->baumgarte_beta;
  double *dv = x + at->v, *l = x + at->lambda;
  for (int i = 0; i < d->nv; i++) dv[i] = r[at->v + i] / cj;
  for (int i = 0; i < d->m; i++) l[i] = r[at->lambda + i] / (cj + alpha2 + beta2 / cj);
  for (int a = 0; a < b->count; a++) {
    const nsdae_event_row *row = &b->row[a];
    double c = row->kind == NSDAE_ROW_CLOSED ? cj + alpha2 + (row->gap ? beta2 / cj : 0) : cj;
    b->f[a] = r[at->normal + row->force] / c;
  }
  memcpy(x + at->normal, r + at->normal, (size_t)(at->n - at->normal) * sizeof *x);
  int status = nsdae_border_solve(&p->newton.border, s->here, dv, l, b->f);
  if (status == NSDAE_OK) status = nsdae_kinematics_at(s->here, dv, x);
  for (int i = 0; i < d->m; i++) l[i] *= cj;
  for (int a = 0; a < b->count; a++) x[at->normal + b->row[a].force] = cj * b->f[a];
  for (int i = 0; i < at->v; i++) x[i] = (x[i] + r[i]) / cj;
  return nsdae_progress_code(status, s->error);
}
