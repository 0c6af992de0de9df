/* The equations for IDA (newton_kkt.h) with the forces of the law:
 *
 *   r_N = F_N - f_N(g, g'),   r_T = F_T + mu F_N v_T / s,   r_S = F_S + L v_S / s
 *   with s = sqrt(v^2 + v_r^2), L = b + mu |lambda|
 *
 * Newton's method, with phi = df / cj, f_g = -df_N/dg, f_g' = -df_N/dg':
 *
 *   cj phi_N + (f_g / cj + f_g') W_N^T dv = r_N
 *   cj phi_T + cj mu v_T / s phi_N + mu F_N (1 / s - v_T v_T^T / s^3) W_T^T dv = r_T
 *   cj phi_S + cj mu sign(lambda) v_S / s l + L v_r^2 / s^3 W_S^T dv = r_S
 *
 * The derivative of b with respect to v is left out. */
#include "equations.h"
#include "stalled_steps.h"
#include "vector.h"

#include <math.h>
#include <string.h>

enum {
  MOTION_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                 NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA | NSDAE_TERM_SLIDE | NSDAE_TERM_BOUND
};

/* ---- the residual */

/* Terms at q*, and the contact forces of the law; r_q. */
static int move(nsdae_penalty_equations *p, double t, const double *y, const double *ydot,
                double cj, double *r)
{
  nsdae_terms *T = &p->stepper->middle;
  int status = nsdae_newton_kkt_move(T, t, y, ydot, cj, p->room, r);
  if (status == NSDAE_OK) status = nsdae_penalty_evaluate(p, t, p->room);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, MOTION_TERMS);
  for (int j = 0; j < T->system->dims.f && status == NSDAE_OK; j++)
    p->at.v_s[j] = nsdae_terms_slide_rate(T, j, T->v);
  return status;
}

/* Regularised speed of contact i. */
static double speed(const nsdae_penalty_equations *p, int i)
{
  int nt = p->stepper->system->dims.nt;
  return hypot(nsdae_norm(nt, p->at.v_t + i * nt), p->stepper->options->friction_velocity);
}

int nsdae_penalty_residual(double t, const double *y, const double *ydot, double cj, double *r,
                           void *user)
{
  nsdae_penalty_equations *p = user;
  const nsdae_terms *T = &p->stepper->middle;
  const nsdae_system *s = T->system;
  const nsdae_sim_options *o = p->stepper->options;
  const nsdae_dims *d = &s->dims;
  const nsdae_penalty_forces *at = &p->at;
  int status = move(p, t, y, ydot, cj, r);
  if (status < 0) return nsdae_progress_code(status, p->stepper->error);
  const double *lambda = y + nsdae_penalty_at(d).lambda;
  double *v = r + d->nq;

  /* ---- forces */
  const double *normal = y + nsdae_penalty_at(d).normal, *slide = y + nsdae_penalty_at(d).slide;
  const double *tangential = y + nsdae_penalty_at(d).tangential;
  for (int i = 0; i < d->k; i++) {
    r[nsdae_penalty_at(d).normal + i] = normal[i] - at->normal[i];
    double part = s->contact[i].mu * normal[i] / speed(p, i);
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++)
      r[nsdae_penalty_at(d).tangential + j] = tangential[j] + part * at->v_t[j];
  }
  for (int j = 0; j < d->f; j++) {
    double size = hypot(at->v_s[j], o->friction_velocity);
    r[nsdae_penalty_at(d).slide + j] =
        slide[j] + nsdae_terms_friction_limit(T, j, lambda) * at->v_s[j] / size;
  }

  /* ---- motion */
  nsdae_newton_kkt_residual(T, o->baumgarte_alpha, o->baumgarte_beta, y, ydot, r);
  nsdae_penalty_add_forces(T, &T->by.normal, 1, -1, normal, v);
  nsdae_penalty_add_forces(T, &T->by.tangent, d->nt, -1, tangential, v);
  for (int i = 0; i < d->f; i++)
    nsdae_rows_add(&s->blocks, &T->by.frictional_joint, i, -slide[i], v);
  return 0;
}

/* ---- Newton's matrix */

static int add(nsdae_penalty_equations *p, const nsdae_rows *rows, int i, int force)
{
  int a = nsdae_border_add(&p->newton.border, rows, i);
  p->border_force[a] = force;
  *nsdae_border_entry(&p->newton.border, a, a) = p->cj;
  return a;
}

static void add_contact(nsdae_penalty_equations *p, int i)
{
  const nsdae_terms *T = &p->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  const nsdae_coefficients *c = &T->system->contact[i];
  nsdae_border *b = &p->newton.border;
  double slope[2], s = speed(p, i), force = c->mu * p->at.normal[i];
  nsdae_penalty_slopes(&p->law, -T->gap[i], -p->at.v_n[i], p->base.start_rate[i], c->e_n,
                       p->base.mass[i], slope);
  int normal = add(p, &T->by.normal, i, i);
  nsdae_border_depend(b, normal, &T->by.normal, i, slope[0] / p->cj + slope[1]);
  for (int j = i * d->nt; j < (i + 1) * d->nt && c->mu > 0; j++) {
    int a = add(p, &T->by.tangent, j, d->k + j);
    for (int l = i * d->nt; l < (i + 1) * d->nt; l++)
      nsdae_border_depend(b, a, &T->by.tangent, l,
                          force / s * ((j == l) - p->at.v_t[j] * p->at.v_t[l] / (s * s)));
    *nsdae_border_entry(b, a, normal) = p->cj * c->mu * p->at.v_t[j] / s;
  }
}

static void add_joint(nsdae_penalty_equations *p, int j)
{
  const nsdae_terms *T = &p->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  const nsdae_frictional_joint *joint = &T->system->frictional_joint[j];
  double v = p->at.v_s[j], regular = p->stepper->options->friction_velocity, s = hypot(v, regular);
  int a = add(p, &T->by.frictional_joint, j, d->k * (1 + d->nt) + j);
  nsdae_border_depend(&p->newton.border, a, &T->by.frictional_joint, j,
                      nsdae_terms_friction_limit(T, j, p->at.lambda) * regular * regular /
                          (s * s * s));
  if (joint->mu == 0) return;
  double lambda = p->at.lambda[joint->constraint];
  p->newton.border.row[a].multiplier = joint->constraint;
  p->newton.border.row[a].h = p->cj * joint->mu * copysign(1, lambda) * v / s;
}

int nsdae_penalty_setup(double t, const double *y, const double *ydot, double cj, void *user)
{
  nsdae_penalty_equations *p = user;
  nsdae_stepper *s = p->stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = &s->system->dims;
  (void)ydot;
  p->cj = cj;
  int status = nsdae_penalty_evaluate(p, t, y);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, MOTION_TERMS);
  if (status == NSDAE_OK)
    status = nsdae_newton_kkt_factor(&p->newton, T, cj, p->rank < d->m ? p->basis : NULL, p->rank);
  if (status < 0) return nsdae_progress_code(status, s->error);
  nsdae_penalty_take(p, y);
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(s->system, n);
    if (p->base.closed[i]) add_contact(p, i);
  }
  for (int j = 0; j < d->f; j++) {
    p->at.v_s[j] = nsdae_terms_slide_rate(T, j, T->v);
    if (nsdae_system_joint_rubs(s->system, j)) add_joint(p, j);
  }
  return nsdae_progress_code(nsdae_border_factor(&p->newton.border, T), s->error);
}

int nsdae_penalty_solve(double cj, double *r, double *x, void *user)
{
  nsdae_penalty_equations *p = user;
  nsdae_stepper *s = p->stepper;
  const nsdae_dims *d = &s->system->dims;
  const nsdae_sim_options *o = s->options;
  double *phi = p->border_room;
  int forces = nsdae_penalty_at(d).normal, n = nsdae_penalty_at(d).work, *place = p->border_force;
  for (int a = 0; a < p->newton.border.count; a++) phi[a] = r[forces + place[a]];
  memcpy(x + forces, r + forces, (size_t)(n - forces) * sizeof *x);
  int status = nsdae_newton_kkt_solve(&p->newton, &s->middle, cj, o->baumgarte_alpha,
                                      o->baumgarte_beta, r, x, phi);
  for (int a = 0; a < p->newton.border.count; a++) x[forces + place[a]] = cj * phi[a];
  return nsdae_progress_code(status, s->error);
}
