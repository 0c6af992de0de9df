/* The equations of a phase for IDA (newton_kkt.h), with the rows of phase.h for the forces:
 *
 *   closed:   r_p = W_p^T v' + omega_p + 2 alpha v_p + beta^2 g
 *   sliding:  r_p = F_p + mu F_N d,  or F_p + (b + mu |lambda|) s
 *   related:  r_p = F_p - sum_l r_l F_l
 *
 * Newton's method, with phi = dF / cj and c = cj + 2 alpha + beta^2 / cj:
 *
 *   closed:   W_p^T dv = r_p / c
 *   sliding:  phi_p + mu d phi_N + mu F_N / cj d'(v_T) W_T^T dv = r_p / cj,
 *             d' = (1 - d d^T) / |v_T| */
#include <string.h>

#include "phase.h"
#include "stalled_steps.h"

/* ---- the residual */

/* mu |lambda| s of frictional joint j. */
static double load_friction(const nsdae_event_phase *p, int j, const double *y)
{
  const nsdae_frictional_joint *joint = &p->setting->system->frictional_joint[j];
  if (joint->mu == 0) return 0;
  return nsdae_event_joint_friction(p, j) * y[p->setting->at.lambda + joint->constraint];
}

/* r of a force that follows from others. */
static double following(const nsdae_event_phase *p, const nsdae_event_row *row, const double *y)
{
  const nsdae_system *s = p->setting->system;
  const double *force = y + p->setting->at.normal;
  int k = s->dims.k, nt = s->dims.nt, all = k * (1 + nt), i = row->force;
  double r = force[i], d[2];
  for (int a = 0; row->kind == NSDAE_ROW_RELATED && a < p->rows.count; a++)
    if (p->rows.row[a].force < all)
      r -= nsdae_event_relation(p, i, p->rows.row[a].force) * force[p->rows.row[a].force];
  if (row->kind == NSDAE_ROW_RELATED) return r;
  if (row->kind == NSDAE_ROW_SLIDE_RUBS)
    return r - nsdae_event_dry_friction(p, i - all) + load_friction(p, i - all, y);
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
  int status = nsdae_newton_kkt_move(p->setting->here, t, y, ydot, cj, p->moved, r);
  nsdae_event_move(p->setting, t, p->moved);
  if (status == NSDAE_OK) status = nsdae_event_need(p);
  if (status < 0) return nsdae_progress_code(status, p->setting->error);
  nsdae_newton_kkt_residual(T, o->baumgarte_alpha, o->baumgarte_beta, y, ydot, r);
  memcpy(r + at->normal, y + at->normal, (size_t)(at->n - at->normal) * sizeof *r);
  for (int j = 0; j < s->dims.f; j++) p->circle[j] = nsdae_terms_circle(s, j, y + at->lambda);
  for (int a = 0; a < b->count; a++) {
    const nsdae_event_row *row = &b->row[a];
    nsdae_rows_add(&s->blocks, row->rows, row->index, -y[at->normal + row->force], r + at->v);
    r[at->normal + row->force] =
        row->kind == NSDAE_ROW_CLOSED
            ? nsdae_rows_dot(&s->blocks, row->rows, row->index, ydot + at->v) -
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
  int status = nsdae_event_need(p);
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
  const nsdae_sim_options *o = s->options;
  double alpha = o->baumgarte_alpha, beta = o->baumgarte_beta;
  for (int a = 0; a < b->count; a++) {
    const nsdae_event_row *row = &b->row[a];
    double c =
        row->kind == NSDAE_ROW_CLOSED ? cj + 2 * alpha + (row->gap ? beta * beta / cj : 0) : cj;
    b->f[a] = r[at->normal + row->force] / c;
  }
  memcpy(x + at->normal, r + at->normal, (size_t)(at->n - at->normal) * sizeof *x);
  int status = nsdae_newton_kkt_solve(&p->newton, s->here, cj, alpha, beta, r, x, b->f);
  for (int a = 0; a < b->count; a++) x[at->normal + b->row[a].force] = cj * b->f[a];
  return nsdae_progress_code(status, s->error);
}
