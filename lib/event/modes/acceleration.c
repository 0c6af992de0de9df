#include "acceleration.h"

#include <math.h>
#include <string.h>

#include "errors.h"

void nsdae_event_acceleration_layout(nsdae_event_acceleration *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->phase->setting->system->dims;
  long k = d->k, columns = k * (1 + d->nt) + d->f;
  nsdae_contacts_layout(&p->problem, d, arena);
  nsdae_hyperstatic_layout(&p->sharing, d, arena);
  p->law = nsdae_arena_take(arena, k, sizeof *p->law);
  nsdae_impulses_layout(&p->solution, d, arena);
  p->sense = NSDAE_ARENA_INTS(arena, d->f);
  nsdae_arena_doubles(arena, d->nv, (double **[]){&p->a, &p->size, NULL});
  p->lambda = NSDAE_ARENA_DOUBLES(arena, d->m);
  nsdae_arena_doubles(arena, columns, (double **[]){&p->force, &p->xi, NULL});
  p->bound = NSDAE_ARENA_DOUBLES(arena, d->f);
  int **of_contact[] = {&p->is.touching, &p->is.candidate, &p->is.released, &p->is.breakaway,
                        &p->is.stopped,  &p->is.moving,    &p->is.closed};
  int **of_slide[] = {&p->is.slide_breakaway, &p->is.slide_stopped, &p->is.slide_turned};
  for (int i = 0; i < 7; i++) *of_contact[i] = NSDAE_ARENA_INTS(arena, k);
  for (int i = 0; i < 3; i++) *of_slide[i] = NSDAE_ARENA_INTS(arena, d->f);
  p->problem.slides.sense = p->sense;
}

void nsdae_event_acceleration_prepare(nsdae_event_acceleration *p)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_dims *d = &s->system->dims;
  int edges = nsdae_law_edges_to_start(s->options->polygon);
  p->problem.given = p->law;
  p->problem.cones.most = d->nt == 2 ? d->k : 0;
  nsdae_contacts_set(&p->problem, s->system, s->error, s->options->contact_tol, edges);
  p->around = d->nt == 2 ? cos(acos(-1) / edges) : 1;
}

/* Of contact i that does not slide: a polygon is put around the friction cone, so that a contact
 * that would leave it does slide. */
static nsdae_law resting(const nsdae_event_acceleration *p, int i)
{
  const nsdae_contacts *c = &p->problem;
  return nsdae_law_make(c->system->dims.nt, c->system->contact[i].mu / p->around, c->edges,
                        c->lcp.edge);
}

/* Fills the direction of sliding of contact i; 0 where it has none. At a slip that was found at
 * zero there is none. */
static int slides(nsdae_event_acceleration *p, int i, int impacted, double size)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_terms *T = s->here;
  int nt = T->system->dims.nt, slid = 0;
  double v_t[2] = {0}, speed = 0;
  double *direction = p->phase->modes.direction + i * nt;
  if (!(T->system->contact[i].mu > 0)) return 0;
  if (p->is.breakaway[i] && !impacted) return 1;
  for (int l = 0; l < nt; l++) {
    v_t[l] = nsdae_terms_tangent_rate(T, i * nt + l, T->v);
    speed = hypot(speed, v_t[l]);
    slid |= p->phase->modes.contact[i] == NSDAE_MODE_SLIP && direction[l] != 0;
  }
  double slow = 10 * size * (nt == 1 ? p->phase->modes.blur[i] : 1);
  int stopped = !impacted && p->is.stopped[i] && slid && speed <= slow;
  int moves = speed > size && !stopped;
  for (int l = 0; l < nt; l++) direction[l] = moves ? v_t[l] / speed : 0;
  return moves;
}

static int slide_sense(const nsdae_event_acceleration *p, int j, int impacted, double size)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_event_modes *m = &p->phase->modes;
  if (p->is.slide_breakaway[j] && !impacted) return m->slide_sense[j];
  double speed = nsdae_terms_slide_rate(s->here, j, s->here->v);
  int stopped = !impacted && p->is.slide_stopped[j] && m->frictional_joint[j] == NSDAE_MODE_SLIP &&
                m->slide_sense[j] != 0;
  if (stopped || !(fabs(speed) > size)) return 0;
  return speed > 0 ? 1 : -1;
}

void nsdae_event_set_laws(nsdae_event_acceleration *p, int impacted, double size)
{
  const nsdae_system *s = p->phase->setting->system;
  int nt = s->dims.nt;
  for (int i = 0; i < s->dims.k; i++) {
    if (!p->is.candidate[i]) continue;
    p->is.moving[i] = slides(p, i, impacted, size);
    p->law[i] = p->is.moving[i]
                    ? nsdae_law_sliding(nt, s->contact[i].mu, p->phase->modes.direction + i * nt)
                    : resting(p, i);
  }
  for (int j = 0; j < s->dims.f; j++) p->sense[j] = slide_sense(p, j, impacted, size);
}

static int solve_bounded(nsdae_event_acceleration *p)
{
  nsdae_event_setting *s = p->phase->setting;
  nsdae_terms T = *s->here;
  int n = s->system->dims.nv, m = s->system->dims.m;
  T.w_N = T.omega.N;
  T.w_T = T.omega.T;
  T.frictional_joint.w = T.frictional_joint.omega;
  nsdae_contacts_close_marked(&p->problem, p->is.candidate, &p->solution);
  memcpy(p->a, T.F, (size_t)n * sizeof *p->a);
  memcpy(p->size, T.F, (size_t)n * sizeof *p->size);
  for (int i = 0; i < m; i++) p->lambda[i] = -T.constraint.omega[i];
  nsdae_kkt_solve_mass(s->kkt, p->size);
  int status = nsdae_terms_solve(s->here, s->kkt, 1, p->a, p->lambda);
  if (status == NSDAE_OK) status = nsdae_event_solve(s, &p->problem, &T, p->size, p->a, p->lambda);
  if (status == NSDAE_OK)
    status = nsdae_terms_finite(s->here, "acceleration", NSDAE_NAME_VELOCITY, p->a);
  return status < 0 ? status
                    : nsdae_terms_finite(s->here, "multiplier", NSDAE_NAME_CONSTRAINT, p->lambda);
}

static int solve(nsdae_event_acceleration *p)
{
  const nsdae_terms *T = p->phase->setting->here;
  nsdae_circles circles = nsdae_circles_begin(T, T->frictional_joint.bound, NULL, NSDAE_CIRCLE_PART,
                                              nsdae_largest(T->system->dims.nv, T->F), p->bound);
  int status;
  p->problem.slides.bound = p->bound;
  do status = solve_bounded(p);
  while (nsdae_circles_again(&circles, p->lambda, &status));
  return status;
}

/* Where the polygons' problem was not solved, the cones' may be. */
int nsdae_event_accelerate(nsdae_event_acceleration *p, nsdae_painleve_margin margin)
{
  int status = solve(p);
  p->by_cones = status == NSDAE_E_LCP &&
                nsdae_projected_gauss_seidel_anew(&p->problem, p->phase->modes.direction, p->force,
                                                  p->xi, p->a, p->lambda);
  nsdae_result *r = p->phase->setting->result;
  if (p->by_cones) {
    nsdae_error_clear(p->phase->setting->error);
    r->worst_residual = fmax(r->worst_residual, p->problem.lcp.info.residual);
  }
  return nsdae_painleve_judge(&p->problem, p->by_cones ? NSDAE_OK : status, !p->by_cones, margin,
                              p->phase->setting->here->t);
}

int nsdae_event_diagnose(nsdae_event_acceleration *p, double t, const double *y)
{
  nsdae_event_setting *s = p->phase->setting;
  nsdae_error kept = *s->error;
  nsdae_event_move(s, t, y);
  int status = nsdae_terms_need(s->here, NSDAE_EVENT_TERMS);
  if (status == NSDAE_OK) status = nsdae_event_factor(s);
  if (status == NSDAE_OK) {
    for (int i = 0; i < s->system->dims.k; i++)
      p->is.candidate[i] = p->phase->modes.contact[i] != NSDAE_MODE_OPEN;
    nsdae_event_set_laws(p, 1, nsdae_event_velocity_size(s));
    status = nsdae_event_accelerate(p, NSDAE_PAINLEVE_NEAR);
  }
  if (status == NSDAE_E_PAINLEVE) return status;
  *s->error = kept;
  return NSDAE_OK;
}

double nsdae_event_acceleration_size(const nsdae_event_acceleration *p)
{
  int n = p->phase->setting->system->dims.nv;
  double most = fmax(nsdae_largest(n, p->a), nsdae_largest(n, p->size));
  return fmax(1e-10 * most, 10 * fmin(p->phase->setting->error_by_differences[1],
                                      NSDAE_EVENT_DIFFERENCES * most));
}
