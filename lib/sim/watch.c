/* See watch.h. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "errors.h"
#include "sim_impl.h"
#include "vector.h"

static const double watch_late = 1.5; /* ways of a step: found late, and that of the hit */
static const double watch_turn = 6.28318530717958648; /* the same, in a turn: one for a radian, */
static const double watch_half_turn = 3.14159265358979324; /* a half for a radian */
static const double watch_sudden = 2;                      /* depths of rest */
static const double watch_quarter = 0.25;                  /* of the width of a body */
static const double watch_tenth = 0.1;                     /* of an arm: 0.1 rad */
static const double watch_share = 0.1;                     /* of the largest kinetic energy */
static const double watch_turnover =
    0.02;                                 /* of the work that forces, or what moves, did and took */
static const double watch_half = 0.5;     /* of the largest that came from somewhere */
static const double watch_soars = 100;    /* times the kinetic energy in a step */
static const double watch_steps = 100;    /* of the integrator's tolerance, in a step */
static const double watch_instants = 200; /* the same, at an instant: what has strayed by 10
                                             times 10 rtol is projected, of T twice that */
static const double watch_inertia = 1e-5; /* of T' by differences */

enum { SOARED = 3 }; /* in so many steps */

static double largest_entry(const nsdae_blocks *blocks, const nsdae_rows *rows)
{
  double most = 0;
  for (int i = 0; i < rows->count; i++) most = fmax(most, nsdae_rows_largest(blocks, rows, i));
  return most;
}

/* The forces at the start's place with v = 0: a damper that brakes what is fast leads nothing that
 * rests anywhere. What is not defined there is as it is at the start. */
static int force_at_rest(const nsdae_terms *T, double *still, double *F)
{
  const nsdae_system *s = T->system;
  size_t size = (size_t)s->dims.nv * sizeof *F;
  memcpy(F, T->F, size);
  if (nsdae_largest(s->dims.nv, T->v) == 0) return NSDAE_OK;
  memset(still, 0, size);
  memset(F, 0, size);
  int code = s->call.force(nsdae_terms_time(T), T->q, still, F, s->user);
  for (int i = 0; i < s->dims.nv; i++)
    if (!isfinite(F[i])) F[i] = T->F[i];
  return nsdae_system_callback_status(code, "force", nsdae_terms_time(T), T->error);
}

/* The way that the forces F lead to in a step from rest: h^2 F / M. */
static double way_from_rest(const nsdae_terms *T, const double *F, double h)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  double rows = fmax(largest_entry(blocks, &T->by.jacobian), largest_entry(blocks, &T->by.normal));
  double most = 0;
  for (int b = 0; b < blocks->count; b++) {
    size_t n = (size_t)nsdae_blocks_size(blocks, b);
    const double *f = F + blocks->first[b], *M = T->M + blocks->square[b];
    for (size_t j = 0; j < n; j++) most = fmax(most, fabs(f[j]) / M[j * (n + 1)]);
  }
  return h * h * rows * most;
}

/* The rounding of the kinetic energy that the forces F lead to in a step from rest: what is held
 * has none of it, and is not told of that. */
static double rounding_from_rest(const nsdae_terms *T, const double *F, double h)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  double sum = 0;
  for (int b = 0; b < blocks->count; b++) {
    size_t n = (size_t)nsdae_blocks_size(blocks, b);
    const double *f = F + blocks->first[b], *M = T->M + blocks->square[b];
    for (size_t j = 0; j < n; j++) sum += f[j] * f[j] / M[j * (n + 1)];
  }
  return DBL_EPSILON * h * h * sum / 2;
}

/* The largest gap, if start_tol does not make it none; else 0, as of penalty, whose stiffness gives
 * the depth. */
static double apart(const nsdae_terms *start, const nsdae_sim_options *o)
{
  double most = 0, start_tol = o->start_tol;
  if (o->method == NSDAE_METHOD_PENALTY) return 0;
  for (int i = 0; i < start->system->dims.k; i++) most = fmax(most, start->gap[i]);
  return most > start_tol * (1 + nsdae_largest(start->system->dims.nq, start->q)) ? most : 0;
}

int nsdae_watch_start(const nsdae_sim *sim, nsdae_point *point)
{
  const nsdae_terms *start = &point->result.end;
  const nsdae_dims *d = &start->system->dims;
  double *still = sim->probe, *F = still + d->nv, h = sim->options.dt;
  int status = force_at_rest(start, still, F);
  if (status < 0) return status;
  double from_rest = way_from_rest(start, F, h);
  point->accounts.watch =
      (nsdae_watch){.change = from_rest,
                    .row = largest_entry(&start->system->blocks, &start->by.jacobian),
                    .way = from_rest,
                    .apart = apart(start, &sim->options),
                    .scale = fmax(point->record.kinetic, rounding_from_rest(start, F, h)),
                    .kinetic = point->record.kinetic,
                    .known = point->record.kinetic,
                    .t = start->t,
                    .power = point->work.power};
  point->accounts.watch.earlier = point->accounts.watch.power;
  return NSDAE_OK;
}

/* One array of a record, `each` numbers for every item of a kind (-1: of none). */
typedef struct part {
  const char *name;
  const double *value;
  int count, kind, each;
} part;

enum { OF_NONE = -1, OF_ONE = -2 }; /* kinds of what has numbers and no names, and of one number */

/* item: of a kind that entry index belongs to. */
static int refuse(const nsdae_result *result, const char *name, int index, double value, int kind,
                  int item)
{
  const nsdae_terms *end = &result->end;
  char place[16] = "";
  if (kind != OF_ONE) snprintf(place, sizeof place, "[%d]", index);
  nsdae_error_set(end->error, NSDAE_E_NONFINITE, "nsdae_sim", name,
                  "%s%s is %g at t = %.17g: the values overflow, and the step was dropped", name,
                  place, value, nsdae_terms_time(end));
  if (kind >= 0) nsdae_system_name_item(end->system, kind, item, end->error);
  end->error->index = index;
  end->error->time = nsdae_terms_time(end);
  return NSDAE_E_NONFINITE;
}

static int refuse_part(const nsdae_result *result, const part *p, int index)
{
  return refuse(result, p->name, index, p->value[index], p->kind, index / p->each);
}

/* Which of the values is not finite; NSDAE_OK where none is. */
static int find_not_finite(const nsdae_point *point)
{
  const nsdae_result *result = &point->result;
  const nsdae_record *r = &point->record;
  const nsdae_dims *d = &result->end.system->dims;
  const part parts[] = {
      {"time", &r->time, 1, OF_ONE, 1},
      {"q", r->q, d->nq, NSDAE_NAME_COORDINATE, 1},
      {"v", r->v, d->nv, NSDAE_NAME_VELOCITY, 1},
      {"kinetic", &r->kinetic, 1, OF_ONE, 1},
      {"potential", &r->potential, 1, OF_ONE, 1},
      {"dissipated", &r->dissipated, 1, OF_ONE, 1},
      {"multiplier", r->multiplier, d->m, NSDAE_NAME_CONSTRAINT, 1},
      {"gap", r->gap, d->k, NSDAE_NAME_CONTACT, 1},
      {"normal_impulse", r->normal_impulse, d->k, NSDAE_NAME_CONTACT, 1},
      {"tangential_impulse", r->tangential_impulse, d->k * d->nt, NSDAE_NAME_CONTACT, d->nt},
      {"slide_impulse", r->slide_impulse, d->f, NSDAE_NAME_SLIDE, 1},
      {"contacts.gap", r->contacts.gap, r->contacts.count, OF_NONE, 1},
      {"contacts.normal_impulse", r->contacts.normal_impulse, r->contacts.count, OF_NONE, 1},
      {"contacts.tangential_impulse", r->contacts.tangential_impulse, r->contacts.count * d->nt,
       OF_NONE, 1},
      {"certificate.work", &r->certificate.work, 1, OF_ONE, 1},
      {"certificate.unexplained", &r->certificate.unexplained, 1, OF_ONE, 1},
      {"certificate.constraint_rate", &r->certificate.constraint_rate, 1, OF_ONE, 1},
      {"certificate.complementarity", &r->certificate.complementarity, 1, OF_ONE, 1},
      {"lcp_residual", &r->lcp_residual, 1, OF_ONE, 1},
      {"constraint_drift", &r->constraint_drift, 1, OF_ONE, 1}};
  for (size_t p = 0; p < sizeof parts / sizeof *parts; p++)
    for (int i = 0; i < parts[p].count; i++)
      if (!isfinite(parts[p].value[i])) return refuse_part(result, &parts[p], i);
  double energy = r->kinetic + r->potential + r->dissipated;
  if (!isfinite(energy)) return refuse(result, "energy", 0, energy, OF_ONE, 0);
  for (int i = 0; i < r->impacts; i++) {
    const nsdae_impact *p = &r->impact[i];
    double sum = p->normal_impulse + p->tangential_impulse[0] + p->tangential_impulse[1] +
                 p->velocity_before + p->velocity_after + p->peak_force;
    if (!isfinite(sum))
      return refuse(result, "impact", i, sum, d->k > 0 ? NSDAE_NAME_CONTACT : OF_NONE, p->contact);
  }
  return NSDAE_OK;
}

static double sum(const double *a, int n)
{
  double s = 0;
  for (int i = 0; i < n; i++) s += a[i];
  return s;
}

static double sum_of_impacts(const nsdae_record *r)
{
  double s = 0;
  for (const nsdae_impact *p = r->impact, *end = p + r->impacts; p < end; p++)
    s += p->normal_impulse + p->tangential_impulse[0] + p->tangential_impulse[1] +
         p->velocity_before + p->velocity_after + p->peak_force;
  return s;
}

/* A finite sum has finite terms: where it is none they are looked at one by one. In it are not: the
 * energies, of which work and unexplained are sums; v, of which kinetic is none unless all are
 * finite; gaps, which were looked at as they came. */
int nsdae_watch_finite(const nsdae_point *point)
{
  const nsdae_record *r = &point->record;
  const nsdae_dims *d = &point->result.end.system->dims;
  int listed = r->contacts.count;
  const nsdae_certificate *c = &r->certificate;
  double all = r->time + c->work + c->unexplained + r->lcp_residual + r->constraint_drift +
               c->constraint_rate + c->complementarity;
  all += sum(r->q, d->nq) + sum(r->multiplier, d->m) + sum(r->normal_impulse, d->k) +
         sum(r->tangential_impulse, d->k * d->nt) + sum(r->slide_impulse, d->f);
  if (listed > 0)
    all += sum(r->contacts.gap, listed) + sum(r->contacts.normal_impulse, listed) +
           sum(r->contacts.tangential_impulse, listed * d->nt);
  if (r->impacts > 0) all += sum_of_impacts(r);
  return isfinite(all) ? NSDAE_OK : find_not_finite(point);
}

/* Lengths: how far gaps and rows of constraints go in a step. */
static void measure(nsdae_watch *w, const nsdae_terms *from, const nsdae_result *result)
{
  const nsdae_terms *to = &result->end;
  const nsdae_dims *d = &to->system->dims;
  const nsdae_impulses *r = &result->impulses;
  double speed = 0, h = to->t - from->t;
  for (int i = 0; i < d->k; i++) {
    w->change = nsdae_larger(w->change, fabs(to->gap[i] - from->gap[i]));
    if (w->apart > 0) w->apart = nsdae_larger(w->apart, to->gap[i]);
  }
  for (int a = 0; a < result->closed.count; a++)
    w->change = fmax(w->change, h * fmax(fabs(r->before[a]), fabs(r->after[a])));
  if (d->m == 0) return; /* no row to go along */
  for (int j = 0; j < d->nv; j++)
    speed = nsdae_larger(speed, nsdae_larger(fabs(from->v[j]), fabs(to->v[j])));
  w->way = nsdae_larger(w->way, h * w->row * speed);
}

/* The step that led to here, by its own quadrature. */
static void add_work(nsdae_watch *w, const nsdae_point *at)
{
  const nsdae_work *of = &at->work;
  double h = at->result.end.t - w->t;
  if (!(h > 0)) return;
  w->rounding += of->rounding;
  w->turnover += fabs(of->forces);
  w->unsure += h / 4 * fabs(of->power - 2 * w->power + w->earlier);
  w->driven += fabs(of->driven);
  w->earlier = w->power;
  w->power = of->power;
  w->t = at->result.end.t;
}

static double energy_bound(const nsdae_watch *w)
{
  double soon = watch_share * w->scale + watch_turnover * w->turnover;
  double ever = watch_half * w->known + watch_turnover * w->spent + w->unsure;
  return (soon < ever ? soon : ever) + watch_turnover * w->driven + w->rounding;
}

/* The lightest diagonal entry of M among those of a block; INFINITY of the ground. */
static double lightest(const nsdae_terms *T, int block)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  double least = INFINITY;
  size_t n = block < 0 ? 0 : (size_t)nsdae_blocks_size(blocks, block);
  for (size_t j = 0; j < n; j++) least = fmin(least, T->M[blocks->square[block] + j * (n + 1)]);
  return least;
}

/* What contact impulses L do on velocities that are rounded as those that they give are: a column
 * at rest gains and loses that in every step. L_i turns its contact's velocity by G_ii L_i, with
 * the Delassus matrix G, and that of j by sqrt(G_ii G_jj) L_i at most. Of lists 1 / G_ii is the
 * lightest that the two blocks have. A method that steps in time closes its contacts once in a
 * step: those of the problem are those of the impulses. */
static double rounding_of_contacts(const nsdae_point *point)
{
  const nsdae_terms *T = &point->result.end;
  const nsdae_record *r = &point->record;
  const nsdae_contacts *c = point->result.problem;
  double sum = 0;
  for (int a = 0; c && !T->system->by_list && a < c->active_count; a++) {
    size_t diagonal = (size_t)c->first_column[a] * (size_t)(c->columns + 1);
    double inertia = nsdae_larger(0, c->delassus.G[diagonal]); /* where nothing moves, rounding */
    sum += fabs(r->normal_impulse[c->active[a]]) * sqrt(inertia);
  }
  for (int i = 0; i < r->contacts.count; i++) {
    const int *block = r->contacts.block + 2 * (size_t)i;
    double m = fmin(lightest(T, block[0]), lightest(T, block[1]));
    sum += fabs(r->contacts.normal_impulse[i]) / sqrt(m);
  }
  return 4 * DBL_EPSILON * sum * sum;
}

/* Energy that came from nowhere, and its bound; why. */
typedef struct gain {
  double energy, bound;
  enum { BY_STEPS, BY_CONTACTS, BY_SOARING } why;
} gain;

/* Each step multiplies the kinetic energy, whatever the forces' quadrature says of it. */
static void find_soaring(nsdae_watch *w, double before, double after, gain *found)
{
  int soars = after > watch_soars * before && after > watch_soars * w->scale && before > 0;
  w->soared = soars ? w->soared + 1 : 0;
  if (w->soared >= SOARED) *found = (gain){after, watch_soars * before, BY_SOARING};
}

/* By the quadrature up to the point before, with what was known there: where each step multiplies
 * the energy the next one hides it. */
static void find_gain_of_steps(nsdae_watch *w, const nsdae_point *before, const nsdae_point *point,
                               gain *found)
{
  double work = point->result.work;
  add_work(w, before);
  if (work != 0) {
    if (work > 0) w->gained += nsdae_larger(0, work - rounding_of_contacts(point));
    w->spent += fabs(work);
  }
  found->energy = before->record.certificate.unexplained;
  found->bound = energy_bound(w);
}

/* The one of the steps, or of contacts up to this one, that is further beyond. */
static void find_gain(nsdae_watch *w, const nsdae_point *before, const nsdae_point *point,
                      gain *found)
{
  double kinetic = point->record.kinetic;
  *found = (gain){0, 0, BY_STEPS};
  if (before->result.located || point->result.located) {
    w->gained = nsdae_larger(w->gained, -point->record.dissipated);
  } else {
    find_gain_of_steps(w, before, point, found);
  }
  double energy = found->energy;
  if (!point->result.located) find_soaring(w, before->record.kinetic, kinetic, found);
  w->scale = nsdae_larger(w->scale, kinetic);
  w->known = nsdae_larger(w->known, kinetic - nsdae_larger(w->gained, nsdae_larger(0, energy)));
  if (!(w->gained > 0)) return;
  double bound = energy_bound(w);
  if (w->gained - bound > found->energy - found->bound)
    *found = (gain){w->gained, bound, BY_CONTACTS};
}

/* What is said, and of what of a kind (-1: of none). */
typedef struct warning {
  int bit, status;
  const char *argument, *what;
  double value, bound;
  const char *advice;
  int kind, item;
} warning;

static int say(nsdae_point *point, const warning *of)
{
  const nsdae_terms *end = &point->result.end;
  point->accounts.stats.warnings |= of->bit;
  nsdae_error_set(end->error, of->status, "nsdae_sim", of->argument,
                  "at t = %.12g %s %.3g, more than the method explains (%.3g): %s",
                  nsdae_terms_time(end), of->what, of->value, of->bound, of->advice);
  if (end->error) end->error->time = nsdae_terms_time(end);
  if (of->kind >= 0) nsdae_system_name_item(end->system, of->kind, of->item, end->error);
  return of->status;
}

/* A law's gain is there at every dt. */
static int say_energy(nsdae_point *point, const gain *g)
{
  const warning by_contacts = {NSDAE_WATCH_ENERGY,
                               NSDAE_WARN_ENERGY,
                               "kinetic",
                               "the energy that contact impulses gave is",
                               g->energy,
                               g->bound,
                               "their law does where e_N > 0 meets friction or another contact; "
                               "take a smaller e_N or mu, or "
                               "method = event, which bounds it",
                               -1,
                               0};
  const warning by_steps = {NSDAE_WATCH_ENERGY,
                            NSDAE_WARN_ENERGY,
                            "kinetic",
                            "the energy that came from nowhere is",
                            g->energy,
                            g->bound,
                            "make dt smaller",
                            -1,
                            0};
  const warning by_soaring = {NSDAE_WATCH_ENERGY,
                              NSDAE_WARN_ENERGY,
                              "kinetic",
                              "the kinetic energy, for the third time in a row, is",
                              g->energy,
                              g->bound,
                              "the step multiplies it, and follows no motion: make dt smaller",
                              -1,
                              0};
  const warning *const all[] = {&by_steps, &by_contacts, &by_soaring};
  return say(point, all[g->why]);
}

/* The error that is largest against its bound: a share of its size, or the way where that is
 * unknown. */
typedef struct excess {
  double value, bound;
  int item;
} excess;

static void compare(excess *e, int item, double value, double allowed, double way)
{
  double bound = allowed > 0 ? allowed : way;
  if (value * e->bound > e->value * bound) *e = (excess){value, bound, item};
}

/* The smaller of the two blocks of a contact by list; 0: neither is known. */
static double size_of_pair(const double *size, const int *block)
{
  double least = INFINITY;
  for (int s = 0; s < 2; s++)
    if (block[s] >= 0 && size[block[s]] > 0) least = fmin(least, size[block[s]]);
  return isfinite(least) ? least : 0;
}

/* apart: 0, or the bound of a contact that was open as the step began. */
static excess deepest(const double *gap_before, const nsdae_result *r, double way, double apart)
{
  const nsdae_system *s = r->end.system;
  const double *size = s->size[NSDAE_NAME_CONTACT];
  excess e = {0, 1, 0};
  for (int i = 0; i < s->dims.k; i++)
    compare(&e, i, -r->end.gap[i], size ? watch_quarter * size[i] : 0,
            apart > 0 && gap_before[i] > 0 ? fmin(way, apart) : way);
  for (int a = 0; a < r->closed.count; a++)
    compare(&e, a, -r->closed.gap[a],
            size ? watch_quarter * size_of_pair(size, r->closed.block + 2 * (size_t)a) : 0, way);
  return e;
}

static excess furthest(const nsdae_terms *T, double way)
{
  const double *size = T->system->size[NSDAE_NAME_CONSTRAINT];
  excess e = {0, 1, 0};
  for (int i = 0; i < T->system->dims.m; i++)
    compare(&e, i, fabs(T->constraint.phi[i]), size ? watch_tenth * size[i] : 0, way);
  return e;
}

static int say_penetration(nsdae_point *point, const excess *e)
{
  const warning of = {NSDAE_WATCH_PENETRATION,
                      NSDAE_WARN_PENETRATION,
                      "gap",
                      "bodies overlap by",
                      e->value,
                      e->bound,
                      "make dt smaller, set projection = depths, and check gap and gap_normal",
                      point->result.end.system->dims.k > 0 ? NSDAE_NAME_CONTACT : -1,
                      e->item};
  return say(point, &of);
}

static int say_drift(nsdae_point *point, const excess *e)
{
  const warning of = {NSDAE_WATCH_DRIFT,
                      NSDAE_WARN_DRIFT,
                      "constraint",
                      "constraints are violated by",
                      e->value,
                      e->bound,
                      "make dt smaller, or set projection = constraints",
                      NSDAE_NAME_CONSTRAINT,
                      e->item};
  return say(point, &of);
}

static int say_twofold(nsdae_point *point)
{
  const nsdae_terms *end = &point->result.end;
  const nsdae_twofold *of = &point->result.twofold;
  char called[NSDAE_CALLED_SIZE];
  point->accounts.stats.warnings |= NSDAE_WATCH_PAINLEVE;
  nsdae_error_set(end->error, NSDAE_WARN_PAINLEVE, "nsdae_sim", "mu",
                  "%s has two friction forces at t = %.6g (Painleve): that of the multiplier %.6g "
                  "is taken; less friction makes it unique",
                  nsdae_system_called(end->system, NSDAE_NAME_SLIDE, of->slide, called), of->t,
                  of->lambda);
  end->error->time = of->t;
  end->error->index = of->slide;
  return NSDAE_WARN_PAINLEVE;
}

static int say_merged(nsdae_point *point, const nsdae_merged *m)
{
  const nsdae_terms *end = &point->result.end;
  const nsdae_system *s = end->system;
  char one[NSDAE_CALLED_SIZE], other[NSDAE_CALLED_SIZE];
  const long *id = point->result.closed.id;
  point->accounts.stats.warnings |= NSDAE_WATCH_IMPACTS;
  nsdae_error_set(
      end->error, NSDAE_WARN_IMPACTS, "nsdae_sim", "dt",
      "impacts are merged in the step to t = %.6g: %s and %s would hit in turn up to %.3g times: "
      "make dt smaller, or use method = event",
      nsdae_terms_time(end),
      s->by_list ? nsdae_system_called_id(s, id[m->contact], one)
                 : nsdae_system_called(s, NSDAE_NAME_CONTACT, m->contact, one),
      s->by_list ? nsdae_system_called_id(s, id[m->other], other)
                 : nsdae_system_called(s, NSDAE_NAME_CONTACT, m->other, other),
      m->impacts);
  end->error->time = nsdae_terms_time(end);
  end->error->index = m->contact;
  return NSDAE_WARN_IMPACTS;
}

/* The overlap that the method explains if sizes are unknown. Time stepping: see watch.h. penalty: a
 * spring has stored no more than its contact has taken, of what was in motion, or of the work of a
 * load or of a moving wall; a load that is put on suddenly compresses it to twice the depth of
 * rest. */
static double depth_of(const nsdae_sim *sim, const nsdae_point *point)
{
  const nsdae_watch *w = &point->accounts.watch;
  const nsdae_sim_options *o = &sim->options;
  if (o->method != NSDAE_METHOD_PENALTY) return (watch_late + watch_turn) * w->change;
  double n = o->penalty_law == NSDAE_PENALTY_KELVIN_VOIGT ? 1 : o->penalty_exponent;
  double stored = fmax(w->scale, point->record.dissipated);
  return watch_sudden * pow((n + 1) * stored / o->penalty_stiffness, 1 / (n + 1));
}

/* A step of event by implicit finds a contact closed a step late: it overlaps by the way of its gap
 * in the step at most, which is reported; more is no step. */
static int judge_fallback(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point)
{
  const nsdae_terms *from = &before->result.end, *end = &point->result.end;
  double least = sim->options.start_tol * (1 + nsdae_largest(end->system->dims.nq, end->q));
  excess deep = {0, 0, -1};
  for (int i = 0; i < end->system->dims.k; i++)
    if (-end->gap[i] > fmax(least, deep.value))
      deep = (excess){-end->gap[i],
                      fabs(end->gap[i] - from->gap[i]) + nsdae_larger(0, -from->gap[i]), i};
  int known = point->accounts.stats.warnings & NSDAE_WATCH_PENETRATION;
  if (deep.item < 0 || (known && deep.value <= deep.bound)) return NSDAE_OK;
  warning of = {NSDAE_WATCH_PENETRATION,
                NSDAE_WARN_PENETRATION,
                "events_max",
                "a step by implicit in place of event leaves an overlap of",
                deep.value,
                least,
                "make dt smaller, or events_max larger",
                NSDAE_NAME_CONTACT,
                deep.item};
  if (deep.value > deep.bound) of.status = NSDAE_E_CONVERGENCE, of.bound = deep.bound;
  return say(point, &of);
}

/* What is beyond its bound and was not said yet, the gravest first. */
static int judge(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point, const gain *g)
{
  const nsdae_record *r = &point->record;
  int new = ~point->accounts.stats.warnings, fallback = point->result.counters.fallbacks > 0;
  int fell = fallback ? judge_fallback(sim, before, point) : NSDAE_OK;
  if (fell != NSDAE_OK) return fell;
  if (g->energy > g->bound && (new &NSDAE_WATCH_ENERGY)) return say_energy(point, g);
  if (r->penetration > 0 && (new &NSDAE_WATCH_PENETRATION)) {
    const excess e = deepest(before->result.end.gap, &point->result, depth_of(sim, point),
                             point->accounts.watch.apart);
    if (e.value > e.bound) return say_penetration(point, &e);
  }
  if (r->constraint_drift > 0 && (new &NSDAE_WATCH_DRIFT)) {
    const excess e = furthest(&point->result.end, watch_half_turn * point->accounts.watch.way);
    if (e.value > e.bound) return say_drift(point, &e);
  }
  if (point->result.twofold.slide >= 0 && (new &NSDAE_WATCH_PAINLEVE)) return say_twofold(point);
  if (!(new &NSDAE_WATCH_IMPACTS)) return NSDAE_OK;
  const nsdae_merged merged = nsdae_merged_find(sim, before, point);
  return merged.impacts > 0 ? say_merged(point, &merged) : NSDAE_OK;
}

/* sum |M_ij| u_i u_j,  u_i = |v_i| + atol / rtol: a velocity is as good as rtol u_i; slower than
 * impact_velocity it may be none. */
static double energy_size(const nsdae_sim *sim, const nsdae_terms *T)
{
  const nsdae_sim_options *o = &sim->options;
  int n = T->system->dims.nv;
  double least = fmax(o->atol, o->impact_velocity) / o->rtol, sum = 0;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      sum += fabs(T->M[(size_t)j * (size_t)n + (size_t)i]) * (fabs(T->v[i]) + least) *
             (fabs(T->v[j]) + least);
  return sum;
}

/* What rtol explains of a difference between T and what the equations of motion gave to it. */
static double explained(const nsdae_sim *sim, const nsdae_point *before, const nsdae_point *point)
{
  const nsdae_result *r = &point->result;
  const nsdae_counters *c = &r->counters;
  double size = energy_size(sim, &before->result.end);
  size = fmax(size, energy_size(sim, &r->end)) + r->turnover;
  double tolerances =
      watch_steps * (double)(c->iterations + 1) + watch_instants * (double)c->events;
  return sim->options.rtol * tolerances * size + watch_inertia * (size + r->turnover);
}

static int keeps_energy(const nsdae_sim *sim, const nsdae_point *before, const nsdae_point *point)
{
  const nsdae_result *r = &point->result;
  double off = point->record.kinetic - before->record.kinetic - r->gain;
  /* 2 T <= sum |M_ij| max |v|^2: far less than is explained */
  if (fabs(off) <= 2 * watch_inertia * point->record.kinetic) return NSDAE_OK;
  double bound = explained(sim, before, point);
  if (!(fabs(off) > bound)) return NSDAE_OK;
  nsdae_error_set(r->end.error, NSDAE_E_CONVERGENCE, "nsdae_sim", "rtol",
                  "the kinetic energy changed by %.3g up to t = %.17g that no force and no impact "
                  "did, more than rtol = %g explains (%.3g): make rtol smaller, or use method = "
                  "implicit",
                  off, nsdae_terms_time(&r->end), sim->options.rtol, bound);
  r->end.error->time = nsdae_terms_time(&r->end);
  return NSDAE_E_CONVERGENCE;
}

int nsdae_watch_step(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point)
{
  nsdae_watch *w = &point->accounts.watch;
  gain found;
  int status = NSDAE_OK;
  if (point->result.located && sim->options.method == NSDAE_METHOD_EVENT)
    status = keeps_energy(sim, before, point);
  if (status < 0) return status;
  measure(w, &before->result.end, &point->result);
  find_gain(w, before, point, &found);
  return judge(sim, before, point, &found);
}
