#include "impact.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "acceleration.h"

/* Much slower than another. */
static const double SLOWER = 0.1;

/* Of the energy before an impact, a gain that is none; of the largest impulse, one that is none:
 * closed contacts of other bodies have such impulses in the same problem. */
static const double ROUNDING = 1e-12;

void nsdae_event_impacts_layout(nsdae_event_impacts *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->acceleration->phase->setting->system->dims;
  long columns = (long)d->k * (1 + d->nt) + d->f;
  nsdae_contacts_layout(&p->problem, d, arena);
  nsdae_impulses_layout(&p->solution, d, arena);
  nsdae_impulses_layout(&p->plastic, d, arena);
  nsdae_event_accumulation_layout(&p->accumulation, arena);
  nsdae_arena_doubles(arena, d->nv,
                      (double **[]){&p->momentum, &p->v, &p->size, &p->elastic, NULL});
  nsdae_arena_doubles(arena, d->m, (double **[]){&p->multiplier, &p->reaction, NULL});
  nsdae_arena_doubles(arena, d->k, (double **[]){&p->velocity, &p->blur, &p->coming, NULL});
  nsdae_arena_doubles(arena, columns, (double **[]){&p->force, &p->xi, NULL});
  p->bound = NSDAE_ARENA_DOUBLES(arena, d->f);
  p->sequence.hit = NSDAE_ARENA_INTS(arena, d->k);
}

void nsdae_event_impacts_prepare(nsdae_event_impacts *p)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  p->problem.cones.most = s->system->dims.nt == 2 ? s->system->dims.k : 0;
  const nsdae_accuracy accuracy = {.tol = s->options->contact_tol};
  nsdae_contacts_set(&p->problem, s->system, s->error, &accuracy,
                     nsdae_law_edges_to_start(s->options->polygon));
  /* a bounded force has no impulse in an instant: joints without a load take no part */
  int loaded = 0;
  for (int j = 0; j < s->system->dims.f; j++)
    loaded |= s->system->frictional_joint[j].mu > 0 || s->system->frictional_joint[j].rows > 0;
  if (!loaded) p->problem.slides.count = 0;
  p->problem.slides.bound = p->bound;
}

int nsdae_event_touches(const nsdae_event_setting *s, int i)
{
  const nsdae_terms *T = s->here;
  return T->gap[i] <= nsdae_event_position_size(s) &&
         nsdae_terms_normal_rate(T, i, T->v) <= nsdae_event_velocity_size(s);
}

/* v and Lambda without contacts: M v + Phi_q^T Lambda = M v-, Phi_q v = -Phi_t. */
static int solve_free(nsdae_event_impacts *p)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_dims *d = &s->system->dims;
  memcpy(p->v, p->momentum, (size_t)d->nv * sizeof *p->v);
  for (int i = 0; i < d->m; i++) p->multiplier[i] = -s->here->constraint.phi_t[i];
  return nsdae_terms_solve(s->here, s->kkt, 1, p->v, p->multiplier);
}

/* With the contacts' v-_N and polygons. */
static int solve_polygons(nsdae_event_impacts *p)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  memcpy(p->size, p->momentum, (size_t)s->system->dims.nv * sizeof *p->v);
  nsdae_kkt_solve_mass(s->kkt, p->size);
  int status = solve_free(p);
  return status < 0 ? status
                    : nsdae_event_solve(s, &p->problem, s->here, p->size, p->v, p->multiplier);
}

/* v+ of the momentum before: the cones from the polygons' solution or, where there is none or one
 * of no use, anew. */
static int solve_bounded(nsdae_event_impacts *p)
{
  const double *d = p->acceleration->phase->modes.direction;
  int status = solve_polygons(p);
  int pressed = status == NSDAE_OK && nsdae_contacts_pressed(&p->problem);
  if (status == NSDAE_OK && !pressed)
    nsdae_projected_gauss_seidel(&p->problem, d, p->force, p->xi, p->v, p->multiplier);
  if (status != NSDAE_E_LCP && !pressed) return status;
  if (solve_free(p) == NSDAE_OK &&
      nsdae_projected_gauss_seidel_anew(&p->problem, d, p->force, p->xi, p->v, p->multiplier)) {
    nsdae_error_clear(p->acceleration->phase->setting->error);
    return NSDAE_OK;
  }
  if (pressed && (status = solve_polygons(p)) == NSDAE_OK)
    nsdae_projected_gauss_seidel(&p->problem, d, p->force, p->xi, p->v, p->multiplier);
  return status;
}

static int solve(nsdae_event_impacts *p)
{
  const nsdae_terms *T = p->acceleration->phase->setting->here;
  nsdae_circles circles = nsdae_circles_begin(
      T, NULL, NULL, NSDAE_CIRCLE_PART, nsdae_largest(T->system->dims.nv, p->momentum), p->bound);
  int status;
  do status = solve_bounded(p);
  while (nsdae_circles_again(&circles, p->multiplier, &status));
  return status;
}

/* The contacts' velocities before, zero where the integrator's errors could be all of it; in the
 * limit of a sequence, those of elastic contacts that approach alone. */
static void approach(nsdae_event_impacts *p)
{
  double size = nsdae_event_velocity_size(p->acceleration->phase->setting);
  for (int i = 0; i < p->problem.system->dims.k; i++) {
    double v = p->velocity[i], slow = p->blur[i] * size;
    int counts =
        p->sequence.together ? v < -slow && p->problem.system->contact[i].e_n == 1 : fabs(v) > slow;
    p->coming[i] = counts ? v : 0;
  }
  nsdae_contacts_come(&p->problem, p->coming);
}

/* What the solved problem's impulses do. */
static double work_of(nsdae_event_impacts *p)
{
  nsdae_contacts_come(&p->problem, p->velocity);
  double work = nsdae_contacts_work(&p->problem);
  nsdae_contacts_come(&p->problem, p->coming);
  return work;
}

/* The solution with e_N = 0, in place of that with e_N, which is kept. */
static int solve_plastic(nsdae_event_impacts *p)
{
  const nsdae_dims *d = &p->problem.system->dims;
  memcpy(p->elastic, p->v, (size_t)d->nv * sizeof *p->v);
  memcpy(p->reaction, p->multiplier, (size_t)d->m * sizeof *p->multiplier);
  nsdae_impulses_clear(&p->plastic, d);
  memcpy(p->plastic.before_t, p->solution.before_t,
         (size_t)(d->k * d->nt) * sizeof *p->plastic.before_t);
  memcpy(p->plastic.slide_before, p->solution.slide_before,
         (size_t)d->f * sizeof *p->plastic.slide_before);
  p->problem.results = &p->plastic;
  return solve(p);
}

/* Between the two, where no energy is gained: with d the difference of both, the work at the share
 * s of e_N is w_0 + (w_1 - w_0 - c) s + c s^2,  c = d^T M d / 2. */
static void take_share(nsdae_event_impacts *p, double gained, double lost)
{
  const nsdae_dims *d = &p->problem.system->dims;
  for (int i = 0; i < d->nv; i++) p->size[i] = p->elastic[i] - p->v[i];
  double c = nsdae_terms_energy(p->acceleration->phase->setting->here, p->size);
  double b = gained - lost - c, root = sqrt(fmax(0, b * b - 4 * c * lost));
  double share = c > 0 ? fmax(0, fmin(1, (root - b) / (2 * c))) : 0;
  nsdae_blend(d->nv, 1 - share, p->v, p->elastic);
  nsdae_blend(d->m, 1 - share, p->multiplier, p->reaction);
  memcpy(p->v, p->elastic, (size_t)d->nv * sizeof *p->v);
  memcpy(p->multiplier, p->reaction, (size_t)d->m * sizeof *p->multiplier);
  nsdae_impulses_blend(&p->solution, d, 1 - share, &p->plastic);
}

static int loses_nothing(const nsdae_event_impacts *p)
{
  int all = 1;
  for (int i = 0; i < p->problem.system->dims.k; i++)
    all &= !p->acceleration->is.touching[i] || p->problem.system->contact[i].e_n == 1;
  return all;
}

static int is_unsolved(int status)
{
  return status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE;
}

/* v+ with the e_N that is possible. */
static int restitute(nsdae_event_impacts *p, const double *before)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  int status = solve(p);
  if (is_unsolved(status)) {
    memset(p->coming, 0, (size_t)s->system->dims.k * sizeof *p->coming);
    nsdae_contacts_come(&p->problem, p->coming);
    p->sequence.endless |= p->sequence.together && loses_nothing(p);
    nsdae_error_clear(s->error);
    return solve(p);
  }
  double gained = status < 0 ? 0 : work_of(p);
  if (!(gained > ROUNDING * nsdae_terms_energy(s->here, before))) return status;
  status = solve_plastic(p);
  if (status == NSDAE_OK) take_share(p, gained, work_of(p));
  p->problem.results = &p->solution;
  return status;
}

/* Whether this impact is the first of an accumulation that ends now: then the solution is that with
 * the set closed; else it is as before. before [nv] is v-. 1: this set, of what parts with no more
 * than `most`, does not end, or has no solution with the e_N of the others. */
static int settle_set(nsdae_event_impacts *p, const double *before, double most)
{
  nsdae_event_accumulation *a = &p->accumulation;
  int any = nsdae_event_find_set(a, p->v, most);
  if (any <= 0) return any;
  for (int i = 0; i < p->problem.system->dims.k; i++)
    if (a->settles[i]) p->coming[i] = 0;
  nsdae_contacts_come(&p->problem, p->coming);
  int status = solve(p);
  if (status == NSDAE_OK)
    status = nsdae_event_close_set(a, before, p->solution.normal, p->v, p->multiplier);
  if (status < 0 && !is_unsolved(status)) return status;
  if (status == NSDAE_OK && nsdae_event_ends(a, p->v, &p->solution)) return status;
  nsdae_error_clear(p->acceleration->phase->setting->error);
  nsdae_event_unsettle(a);
  approach(p);
  status = restitute(p, before);
  return status < 0 ? status : 1;
}

static void record(nsdae_event_impacts *p, int i)
{
  const nsdae_impulses *c = &p->solution;
  const nsdae_event_accumulation *a = &p->accumulation;
  int nt = p->problem.system->dims.nt, ends = a->settles[i];
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  nsdae_impact *impact =
      nsdae_result_impact(s->result, s->here->t + (ends ? a->rest : 0), i, p->velocity[i]);
  impact->normal_impulse += c->normal[i] + a->normal[i];
  impact->velocity_after = ends ? 0 : c->after[i];
  impact->accumulation |= ends;
  for (int l = 0, j = i * nt; l < nt; l++, j++)
    impact->tangential_impulse[l] += c->tangential[j] + a->tangential[j];
}

/* The set ends because it is slow for the speeds of other bodies, not for those of its own. */
static void note_slow_set(const nsdae_event_impacts *p)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_event_accumulation *a = &p->accumulation;
  double most = 0;
  int fastest = -1;
  for (int i = 0; i < s->system->dims.k; i++) {
    if (!a->settles[i]) continue;
    most = fmax(most, nsdae_event_own_speed(s, i));
    if (fastest < 0 || a->after[i] > a->after[fastest]) fastest = i;
  }
  double own = NSDAE_EVENT_SLOW * nsdae_event_velocity_size_of(s, most);
  if (fastest >= 0 && a->after[fastest] > own &&
      a->after[fastest] <= NSDAE_EVENT_SLOW * nsdae_event_velocity_size(s))
    nsdae_event_unresolved(s, fastest, a->after[fastest]);
}

/* The same of contacts that come together too slowly to have an impact, or part too slowly after
 * one to open. */
static void note_slow(const nsdae_event_impacts *p, int parted)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_event_modes *m = &p->acceleration->phase->modes;
  double size = nsdae_event_velocity_size(s);
  for (int i = 0; i < s->system->dims.k; i++) {
    int met = parted ? p->sequence.hit[i] && !p->accumulation.settles[i]
                     : p->acceleration->is.touching[i] && m->contact[i] == NSDAE_MODE_OPEN;
    if (!met || !(s->system->contact[i].e_n > 0)) continue;
    double rate = (parted ? 1 : -1) * nsdae_terms_normal_rate(s->here, i, s->here->v);
    double own = nsdae_event_velocity_size_of(s, nsdae_event_own_speed(s, i));
    if (rate > own && rate <= size) nsdae_event_unresolved(s, i, rate);
  }
}

/* What the impact did, with what closed a set, for the step. */
static void keep(nsdae_event_impacts *p)
{
  const nsdae_impulses *c = &p->solution;
  const nsdae_event_accumulation *a = &p->accumulation;
  const nsdae_dims *d = &p->problem.system->dims;
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  nsdae_result *r = s->result;
  double none = ROUNDING * nsdae_largest(d->k, c->normal), size = nsdae_event_velocity_size(s);
  int ends = 0, rattled = 0;
  nsdae_contacts_come(&p->problem, p->velocity);
  r->work += nsdae_contacts_work(&p->problem) + a->work;
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(p->problem.system, n);
    if (c->normal[i] > none && c->normal[i] + a->normal[i] > 0) record(p, i);
    rattled |= p->velocity[i] < -size && p->velocity[i] >= -p->blur[i] * size &&
               p->problem.system->contact[i].e_n > 0;
    ends |= a->settles[i];
  }
  nsdae_event_account_impact(p->account, c, p->multiplier);
  nsdae_add(d->k, 1, a->normal, r->impulses.normal);
  nsdae_add(d->k * d->nt, 1, a->tangential, r->impulses.tangential);
  nsdae_terms_add_all_linear(s->here, a->normal, a->tangential, r->impulses.linear);
  if (ends && a->early) note_slow_set(p);
  r->counters.accumulations += ends;
  r->counters.accumulations_early += (ends && a->early) || rattled;
}

/* One problem for all that touch. */
static int impact(nsdae_event_impacts *p, double *y)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  nsdae_terms *T = s->here;
  nsdae_contacts *c = &p->problem;
  const nsdae_dims *d = &s->system->dims;
  double *v = y + s->at.v;
  nsdae_contacts_close_marked(c, p->acceleration->is.touching, &p->solution);
  nsdae_contacts_before(c, T, v, 0);
  memcpy(p->velocity, p->solution.before, (size_t)d->k * sizeof *p->velocity);
  nsdae_event_unsettle(&p->accumulation);
  memset(p->momentum, 0, (size_t)d->nv * sizeof *p->momentum);
  nsdae_blocks_add_product(&s->system->blocks, T->M, v, p->momentum);
  approach(p);
  int status = restitute(p, v);
  if (status == NSDAE_OK) {
    /* The same of smaller and smaller sets, until one ends or none is left. */
    int again = settle_set(p, v, INFINITY);
    while (again > 0) again = settle_set(p, v, SLOWER * p->accumulation.fastest);
    status = again;
  }
  if (status == NSDAE_OK)
    status = nsdae_terms_finite(s->here, "velocity", NSDAE_NAME_VELOCITY, p->v);
  if (status == NSDAE_OK)
    status = nsdae_terms_finite(s->here, "impulse", NSDAE_NAME_CONTACT, p->solution.normal);
  if (status == NSDAE_OK)
    status = nsdae_terms_finite(s->here, "multiplier", NSDAE_NAME_CONSTRAINT, p->multiplier);
  if (status < 0) return status;
  nsdae_event_add_residual(s, c);
  keep(p);
  s->result->gain += nsdae_terms_energy(T, p->v) - nsdae_terms_energy(T, v);
  memcpy(v, p->v, (size_t)d->nv * sizeof *v);
  nsdae_terms_set_velocity(T, v);
  return nsdae_terms_need(T, NSDAE_EVENT_TERMS);
}

static int approaching(const nsdae_event_impacts *p)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_terms *T = s->here;
  for (int i = 0; i < T->system->dims.k; i++)
    if (p->acceleration->is.touching[i] &&
        nsdae_terms_normal_rate(T, i, T->v) < -nsdae_event_velocity_size(s))
      return 1;
  return 0;
}

/* What touches: all that was closed, and all that does not part; for a limit all of the sequence.
 */
static void find_touching(nsdae_event_impacts *p)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  const int *mode = p->acceleration->phase->modes.contact;
  for (int i = 0; i < s->system->dims.k; i++)
    p->acceleration->is.touching[i] = mode[i] != NSDAE_MODE_OPEN || nsdae_event_touches(s, i) ||
                                      (p->sequence.together && p->sequence.hit[i]);
}

/* Accounts for the impact that was. A plastic one takes a dimension: its velocity counts as rtol.
 */
static void shrink(nsdae_event_sequence *q, const nsdae_contacts *c, const double *coming,
                   double rtol)
{
  for (int n = 0; n < c->system->dims.k; n++) {
    int i = nsdae_system_contact(c->system, n);
    if (!(coming[i] < 0)) continue;
    q->hits += !q->hit[i];
    q->hit[i] = 1;
    q->decay += log(fmax(c->system->contact[i].e_n, rtol));
  }
  q->together = q->hits > 0 && q->decay < q->hits * log(rtol);
}

/* An impact may drive another contact that touches, and parted or rested before it, together: then
 * that is the next, at the same time. A light body between heavy ones goes to and fro so for as
 * long as it takes to turn them. After events_max the sequence counts as endless: elastic contacts
 * have one impact together. Another that it brings to touch joins the next: there are k. A body
 * that just fits between two others, and loses nothing, has none: implicit takes the step. */
int nsdae_event_collide(nsdae_event_impacts *p, double *y)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  nsdae_event_sequence *q = &p->sequence;
  int count = 0, most = s->options->events_max;
  memset(q->hit, 0, (size_t)s->system->dims.k * sizeof *q->hit);
  q->hits = q->together = 0;
  q->decay = 0;
  note_slow(p, 0);
  int status = approaching(p) ? nsdae_event_take_flight(&p->accumulation, y) : NSDAE_OK;
  while (status == NSDAE_OK && approaching(p) && count <= most + nsdae_system_contacts(s->system)) {
    status = impact(p, y);
    if (status < 0) break;
    shrink(q, &p->problem, p->coming, s->options->rtol);
    q->together |= ++count >= most;
    find_touching(p);
  }
  if (status < 0) return status;
  if (count > 0) note_slow(p, 1);
  q->endless |= approaching(p);
  q->together = 0;
  return count;
}
