/* Judges every point before it becomes the state: what the method does not explain is reported,
 * once for each kind. docs/methods/warnings.md has the bounds and where they come from. In its
 * letters h is the step, c the largest entry of Phi_q at the start, l = max h c max |v_j| the way
 * along such a row in one step so far, g the largest change of a gap in one; neither is below the
 * way h^2 F / M that the forces of the start lead to from rest, l not below the rounding of a row.
 */
#include <math.h>

#include "errors.h"
#include "sim_impl.h"
#include "vector.h"

static const double pi = 3.14159265358979324; /* ways, in a turn: a half or one for a radian */
static const double watch_late = 1.5;         /* ways: found late, and that of the hit */
static const double watch_sudden = 2;         /* depths of rest */
static const double watch_quarter = 0.25;     /* of the width of a body */
static const double watch_tenth = 0.1;        /* of an arm: 0.1 rad */
static const double watch_share = 0.1;        /* of the largest kinetic energy */
static const double watch_turnover = 0.02;    /* of the work of forces, and of what is driven */
static const double watch_half = 0.5;         /* of the largest that came from somewhere */
static const double watch_lost = 1e3; /* bounds, of those when the gain was first reported */

/* That of a contact which is not listed is more than the reach. */
static double gap_of(const nsdae_terms *T, int i)
{
  const nsdae_tracked *tracked = T->system->tracked;
  return tracked && !(T->gap[i] < NSDAE_FAR) ? tracked->reach : T->gap[i];
}

/* Lengths: how far gaps and rows of constraints go in a step; moved [k]: by projection = slop. */
static void measure_lengths(nsdae_monitors *w, const nsdae_terms *from, const nsdae_result *result,
                            const double *moved)
{
  const nsdae_terms *to = &result->end;
  const nsdae_dims *d = &to->system->dims;
  const nsdae_impulses *r = &result->impulses;
  const nsdae_tracked *tracked = to->system->tracked;
  double speed = 0, h = to->t - from->t;
  for (int i = 0; i < d->k; i++) {
    if (tracked && !tracked->used[i]) continue; /* a free slot has no gap */
    double gap = gap_of(to, i), change = gap - gap_of(from, i);
    /* by a wrong normal the projection goes deeper, and that is no motion */
    double lifted = moved && change < 0 ? nsdae_larger(0, moved[i]) : 0;
    w->change = nsdae_larger(w->change, fabs(change) - lifted);
    if (w->apart > 0) w->apart = nsdae_larger(w->apart, gap);
  }
  for (int a = 0; a < result->closed.count; a++)
    w->change = fmax(w->change, h * fmax(fabs(r->before[a]), fabs(r->after[a])));
  if (result->entered.depth > 0) w->change = fmax(w->change, h * fabs(result->entered.rate));
  if (d->m == 0) return; /* no row to go along */
  for (int j = 0; j < d->nv; j++)
    speed = nsdae_larger(speed, nsdae_larger(fabs(from->v[j]), fabs(to->v[j])));
  w->way = nsdae_larger(w->way, h * w->row * speed);
}

/* The turnover of forces has no limit: in the long run the second bound counts. */
static double energy_bound(const nsdae_monitors *w, const nsdae_work *of)
{
  double soon = watch_share * w->scale + watch_turnover * of->turnover;
  double ever = watch_half * w->known + watch_turnover * of->spent + of->unsure;
  return fmin(soon, ever) + watch_turnover * of->carried + of->rounding;
}

/* What is reported, and of which kind of item (-1: of none). */
typedef struct rule {
  int status, kind;
  const char *argument, *what, *advice;
} rule;

static const rule rules[] = {
    {NSDAE_WARN_ENERGY, -1, "kinetic", "the numerical energy gain is", "make dt smaller"},
    {NSDAE_WARN_ENERGY, -1, "kinetic", "the energy gain by contact impulses is",
     "Newton's law with e_N > 0 and friction or several contacts causes it; use a smaller e_N or "
     "mu, or method = event, which bounds it"},
    {NSDAE_WARN_ENERGY, -1, "kinetic", "the energy loss by contacts whose normals turn is",
     "it is proportional to dt: make dt ten times smaller, or use method = implicit or event"},
    {NSDAE_WARN_PENETRATION, NSDAE_NAME_CONTACT, "gap", "the penetration is",
     "make dt smaller, set projection = depths, and check gap and gap_normal"},
    {NSDAE_WARN_PENETRATION, NSDAE_NAME_CONTACT, "events_max",
     "the penetration after a step of implicit in place of event is",
     "make dt smaller, or events_max larger"},
    {NSDAE_WARN_DRIFT, NSDAE_NAME_CONSTRAINT, "constraint", "the constraint violation is",
     "make dt smaller, or set projection = constraints"}};
enum { OF_STEPS, OF_CONTACTS, OF_TURNS, OF_OVERLAP, OF_FALLBACK, OF_DRIFT };

/* What is off most against its bound. */
typedef struct excess {
  int rule;
  double value, bound;
  int item;
} excess;

static int bit_of(int status)
{
  return NSDAE_MONITORS_ENERGY << (status - NSDAE_WARN_ENERGY);
}

/* Of the contact list: one that the step closed, or the one after these that it did not. */
static long closed_id(const nsdae_result *result, int item)
{
  return item < result->closed.count ? result->closed.id[item] : result->entered.id;
}

static int report(nsdae_point *point, const excess *e, int status)
{
  const nsdae_terms *end = &point->result.end;
  const rule *r = &rules[e->rule];
  point->accounts.stats.warnings |= bit_of(r->status);
  nsdae_error_set(end->error, status, "nsdae_sim", r->argument,
                  "at t = %.12g %s %.3g, above the bound of the method (%.3g): %s",
                  nsdae_terms_time(end), r->what, e->value, e->bound, r->advice);
  end->error->time = nsdae_terms_time(end);
  if (r->kind != NSDAE_NAME_CONTACT || end->system->dims.k > 0)
    nsdae_system_name_item(end->system, r->kind, e->item, end->error);
  else
    nsdae_system_name_listed(end->system, closed_id(&point->result, e->item), end->error);
  return status;
}

/* By the quadrature up to the point before, with what was known there: where each step multiplies
 * the energy the next one hides it. Or of contacts up to this one, if that is further beyond. */
static excess find_gain(nsdae_monitors *w, const nsdae_point *before, const nsdae_point *point)
{
  double kinetic = point->record.kinetic, gained = point->work.gained;
  double turned = point->work.turned;
  excess found = {OF_STEPS, 0, 0, -1};
  if (!before->result.located && !point->result.located)
    found = (excess){OF_STEPS, before->record.certificate.unexplained,
                     energy_bound(w, &before->work), -1};
  w->scale = nsdae_larger(w->scale, kinetic);
  w->known = nsdae_larger(w->known, kinetic - nsdae_larger(gained, nsdae_larger(0, found.value)));
  double bound = energy_bound(w, &point->work);
  if (gained > 0 && gained - bound > found.value - found.bound)
    found = (excess){OF_CONTACTS, gained, bound, -1};
  if (turned - bound > found.value - found.bound) found = (excess){OF_TURNS, turned, bound, -1};
  return found;
}

/* allowed: a share of its size, 0 if that is unknown: then the way counts. */
static void compare_excess(excess *e, int item, double value, double allowed, double way)
{
  double bound = allowed > 0 ? allowed : way;
  if (value * e->bound > e->value * bound) *e = (excess){e->rule, value, bound, item};
}

/* The smaller of the two blocks of a listed contact; 0: neither is known. */
static double size_of_pair(const double *size, const int *block)
{
  double least = INFINITY;
  for (int s = 0; s < 2; s++)
    if (block[s] >= 0 && size[block[s]] > 0) least = fmin(least, size[block[s]]);
  return isfinite(least) ? least : 0;
}

double nsdae_contact_size(const nsdae_system *s, int i)
{
  const double *size = s->size[NSDAE_NAME_CONTACT];
  if (!size || (s->tracked && !s->tracked->used[i])) return 0; /* a free slot has no blocks */
  return s->tracked ? size_of_pair(size, s->tracked->block + 2 * i) : size[i];
}

/* The overlap that the method explains if sizes are unknown. Time stepping: see above; or the
 * rounding of a gap, 1.1 of which projection = slop leaves.
 * penalty: a spring has stored no more than its contact has taken, of what was in motion, or of the
 * work of a load or of a moving wall; a load that is put on suddenly compresses it to twice the
 * depth of rest. */
static double depth_of(const nsdae_sim *sim, const nsdae_point *point)
{
  const nsdae_monitors *w = &point->accounts.watch;
  const nsdae_sim_options *o = &sim->options;
  if (o->method != NSDAE_METHOD_PENALTY)
    return fmax((watch_late + 2 * pi) * w->change, 2 * nsdae_terms_touch(&point->result.end));
  double n = o->penalty_law == NSDAE_PENALTY_KELVIN_VOIGT ? 1 : o->penalty_exponent;
  double stored = fmax(w->scale, point->record.dissipated);
  return watch_sudden * pow((n + 1) * stored / o->penalty_stiffness, 1 / (n + 1));
}

/* Of a contact list the items are those that the step closed, then the one that it did not. A
 * contact that was open as the step began is also held against the largest gap. */
static excess deepest(const nsdae_sim *sim, const nsdae_point *before, const nsdae_point *point)
{
  const nsdae_result *r = &point->result;
  const nsdae_system *s = r->end.system;
  const double *size = s->size[NSDAE_NAME_CONTACT], *gap_before = before->result.end.gap;
  double way = depth_of(sim, point), apart = point->accounts.watch.apart;
  excess e = {OF_OVERLAP, 0, 1, 0};
  for (int i = 0; i < s->dims.k; i++)
    compare_excess(&e, i, -r->end.gap[i], watch_quarter * nsdae_contact_size(s, i),
                   apart > 0 && gap_before[i] > 0 ? fmin(way, apart) : way);
  for (int a = 0; a < r->closed.count; a++)
    compare_excess(&e, a, -r->closed.gap[a],
                   size ? watch_quarter * size_of_pair(size, r->closed.block + 2 * (size_t)a) : 0,
                   way);
  compare_excess(&e, r->closed.count, r->entered.depth,
                 size ? watch_quarter * size_of_pair(size, r->entered.block) : 0, way);
  return e;
}

static excess furthest(const nsdae_point *point)
{
  const nsdae_terms *T = &point->result.end;
  const double *size = T->system->size[NSDAE_NAME_CONSTRAINT];
  excess e = {OF_DRIFT, 0, 1, 0};
  for (int i = 0; i < T->system->dims.m; i++)
    compare_excess(&e, i, fabs(T->constraint.phi[i]), size ? watch_tenth * size[i] : 0,
                   pi * point->accounts.watch.way);
  return e;
}

/* What the forces at T give to bodies at rest in a step, (h F)^2 / 2 M with the diagonal of M: less
 * than that is jitter of bodies at rest. */
static double energy_of_forces(const nsdae_terms *T, double h)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  double sum = 0;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b);
    const double *M = T->M + blocks->square[b], *F = T->F + blocks->first[b];
    for (int i = 0; i < n; i++) sum += F[i] * F[i] / M[(size_t)i * (size_t)(n + 1)];
  }
  return h * h / 2 * sum;
}

/* A gain that goes on to 1e3 times the bound that it exceeded first, and is most of the energy: no
 * later step has a meaning. Unstable steps reach it within some ten; the bound of a motion that
 * truly speeds up grows with it. */
static int judge_growth(const nsdae_sim *sim, nsdae_point *point)
{
  const nsdae_terms *end = &point->result.end;
  double gain = point->record.certificate.unexplained, first = point->accounts.watch.reported;
  if (!(first > 0 && gain > watch_lost * first && gain > watch_half * point->record.kinetic))
    return NSDAE_OK;
  nsdae_error_set(end->error, NSDAE_E_CONVERGENCE, "nsdae_sim", "dt",
                  "at t = %.6g the numerical energy gain is %.3g, %.1g times the bound that it "
                  "exceeded first: the steps are unstable; make dt = %g smaller, or use "
                  "method = event",
                  nsdae_terms_time(end), gain, gain / first, sim->options.dt);
  return nsdae_error_at(end->error, NSDAE_E_CONVERGENCE, -1, nsdae_terms_time(end));
}

/* moreau with constraints takes the gyroscopic term at v_0, by Euler's rule: in a step the energy
 * of the motion across a spin, which turns by Omega h, grows by (Omega h)^2 of it. Of a fast spin
 * that is little of all energy, and the direction of the axis is lost. A tenth of the energy across
 * that the certificate does not explain is reported, if the rule explains at least half of the gain
 * of the step; the gain is proportional to h. */
static int judge_spin(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point, int new)
{
  const nsdae_terms *end = &point->result.end;
  const nsdae_system *s = end->system;
  double gain = point->record.certificate.unexplained, h = point->record.duration;
  double step = gain - before->record.certificate.unexplained;
  nsdae_spin spin;
  if (sim->options.method != NSDAE_METHOD_MOREAU || s->dims.m == 0 || !s->maker.spin ||
      !(new &NSDAE_MONITORS_ENERGY) || !(step > 0))
    return NSDAE_OK;
  s->maker.spin(before->result.end.v, &spin, s->user);
  if (spin.body < 0 || !(gain > watch_share * spin.across && h * h * spin.gain > step / 2 &&
                         h * h * spin.gain < 2 * step))
    return NSDAE_OK;
  point->accounts.stats.warnings |= NSDAE_MONITORS_ENERGY;
  /* what judge_growth goes by, as if the energy of all had been reported */
  point->accounts.watch.reported = fmax(energy_bound(&point->accounts.watch, &before->work),
                                        energy_of_forces(&before->result.end, h));
  nsdae_error_set(end->error, NSDAE_WARN_ENERGY, "nsdae_sim", "dt",
                  "at t = %.6g body %d has omega dt = %.2g: moreau with joints has raised the "
                  "energy across its spin by %.2g of %.2g; make dt smaller than %.2g, or use "
                  "method = implicit or event",
                  nsdae_terms_time(end), spin.body, spin.rate * h, gain, spin.across, h / 10);
  return nsdae_error_at(end->error, NSDAE_WARN_ENERGY, spin.body, nsdae_terms_time(end));
}

/* A step of event by implicit finds a contact closed a step late: it overlaps by the way of its gap
 * in the step at most, which is reported; more is no step. */
static int judge_fallback(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point)
{
  const nsdae_terms *from = &before->result.end, *end = &point->result.end;
  double least = sim->options.start_tol * (1 + nsdae_largest(end->system->dims.nq, end->q)),
         way = 0;
  excess deep = {OF_FALLBACK, 0, least, -1};
  if (point->result.counters.fallbacks == 0) return NSDAE_OK;
  for (int i = 0; i < end->system->dims.k; i++) {
    if (!(-end->gap[i] > fmax(least, deep.value))) continue;
    deep.value = -end->gap[i], deep.item = i;
    way = fabs(end->gap[i] - from->gap[i]) + nsdae_larger(0, -from->gap[i]);
  }
  if (deep.item < 0) return NSDAE_OK;
  if (deep.value > way) return deep.bound = way, report(point, &deep, NSDAE_E_CONVERGENCE);
  int known = point->accounts.stats.warnings & NSDAE_MONITORS_PENETRATION;
  return known ? NSDAE_OK : report(point, &deep, NSDAE_WARN_PENETRATION);
}

/* The law of contacts of a list that were not near at the start. */
static int judge_law(const nsdae_sim *sim, nsdae_point *point)
{
  int *warnings = &point->accounts.stats.warnings;
  if (!sim->model.tracked || (*warnings & NSDAE_MONITORS_RESTITUTION)) return NSDAE_OK;
  int status = nsdae_initial_law(&sim->model, &sim->options, point->result.impulses.normal,
                                 point->result.end.error);
  if (status > 0) *warnings |= NSDAE_MONITORS_RESTITUTION;
  return status;
}

/* event: an approach without its e_N, which a smaller rtol resolves. */
static int judge_unresolved(const nsdae_sim *sim, nsdae_point *point, int new)
{
  const nsdae_unresolved *of = &point->result.unresolved;
  const nsdae_terms *end = &point->result.end;
  char fastest[NSDAE_CALLED_SIZE];
  if (!(of->velocity > 0) || !(new &NSDAE_MONITORS_RESTITUTION)) return NSDAE_OK;
  point->accounts.stats.warnings |= NSDAE_MONITORS_RESTITUTION;
  nsdae_error_set(
      end->error, NSDAE_WARN_RESTITUTION, "nsdae_sim", "rtol",
      "at t = %.6g the velocity %.3g of %s is lost without e_N: the tolerance of velocities, "
      "by rtol = %g and the speed of %s, is %.3g; make rtol smaller than %.2g",
      of->t, of->velocity, of->called, sim->options.rtol,
      nsdae_system_called(end->system, NSDAE_NAME_VELOCITY, of->fastest, fastest), of->tol,
      of->least);
  return nsdae_error_at(end->error, NSDAE_WARN_RESTITUTION, of->contact, of->t);
}

/* A change point: the branch of the motion was chosen. */
static int judge_singular(nsdae_point *point, int new)
{
  const nsdae_crossed *of = &point->result.crossed;
  const nsdae_terms *end = &point->result.end;
  char called[NSDAE_CALLED_SIZE];
  if (of->constraint < 0 || !(new &NSDAE_MONITORS_SINGULAR)) return NSDAE_OK;
  point->accounts.stats.warnings |= NSDAE_MONITORS_SINGULAR;
  double t = nsdae_system_time(end->system, of->t);
  nsdae_error_set(
      end->error, NSDAE_WARN_SINGULAR, "nsdae_sim", "constraint",
      "at t = %.6g %s depends on the other constraints: this pose is a change point, beyond which "
      "two motions exist; the one without a jump of velocities is used",
      t, nsdae_system_called(end->system, NSDAE_NAME_CONSTRAINT, of->constraint, called));
  int index = nsdae_system_index(end->system, NSDAE_NAME_CONSTRAINT, of->constraint);
  return nsdae_error_at(end->error, NSDAE_WARN_SINGULAR, index, t);
}

/* What the solver left of the contact problem of the step; new: warnings not yet given. */
static int judge_residual(const nsdae_sim *sim, nsdae_point *point, int new)
{
  const nsdae_terms *end = &point->result.end;
  if (!(new &NSDAE_MONITORS_CONTACT)) return NSDAE_OK;
  if (!point->result.counters.inexact && point->result.above.hidden > 0) {
    point->accounts.stats.warnings |= NSDAE_MONITORS_CONTACT;
    nsdae_error_set(
        end->error, NSDAE_WARN_CONTACT, "nsdae_sim", "mass",
        "at t = %.12g the loads of light bodies are so large that rounding leaves %.3g of the "
        "velocities of their contacts, more than contact_tol = %.3g%s: use method = event, masses "
        "that differ less, or a larger contact_tol",
        nsdae_terms_time(end), point->result.above.hidden, point->result.above.tol,
        sim->options.contact_tol > 0 ? "" : " (auto)");
    return nsdae_error_at(end->error, NSDAE_WARN_CONTACT, -1, nsdae_terms_time(end));
  }
  if (!point->result.counters.inexact) return NSDAE_OK;
  nsdae_error_set(
      end->error, NSDAE_WARN_CONTACT, "nsdae_sim", "contact_tol",
      "at t = %.12g the contact problem was solved to %.3g, not to contact_tol = %.3g%s: "
      "make contact_tol larger or dt smaller, or set contact_give = 1 to stop there",
      nsdae_terms_time(end), point->result.above.residual, point->result.above.tol,
      sim->options.contact_tol > 0 ? "" : " (auto)");
  return nsdae_error_at(end->error, NSDAE_WARN_CONTACT, -1, nsdae_terms_time(end));
}

/* Of the velocities at the start of the step: a contact that is found too late shows nothing.
 * moreau finds it up to a step late, in the middle of a step, and has the normal of that place. The
 * others find it at the end of a step and look for the normal another step ahead. */
static int judge_tunnelling(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point,
                            int new)
{
  const nsdae_terms *from = &before->result.end, *end = &point->result.end;
  const nsdae_system *s = end->system;
  nsdae_tunnelling found;
  char called[NSDAE_CALLED_SIZE];
  double h = end->t - from->t, steps = sim->options.method == NSDAE_METHOD_MOREAU ? 1 : 2;
  if (!sim->method->closes || !s->maker.tunnelling || !(new &NSDAE_MONITORS_PENETRATION))
    return NSDAE_OK;
  int status = s->maker.tunnelling(from->q, from->v, h, 1 / (2 * steps), &found, s->user);
  if (status < 0) return nsdae_error_memory(end->error, "nsdae_sim");
  if (found.contact < 0) return NSDAE_OK;
  s->maker.words(s->maker.of, NSDAE_NAME_CONTACT, found.contact, called, sizeof called);
  point->accounts.stats.warnings |= NSDAE_MONITORS_PENETRATION;
  nsdae_error_set(
      end->error, NSDAE_WARN_PENETRATION, "nsdae_sim", "dt",
      "at t = %.12g the gap of %s closes by %.3g in a step: they may pass through each other "
      "(tunnelling); make dt smaller than %.2g, or use method = event",
      nsdae_terms_time(from), called, found.way, h * found.least / found.way);
  return nsdae_error_at(end->error, NSDAE_WARN_PENETRATION, -1, nsdae_terms_time(from));
}

int nsdae_monitors_step(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point)
{
  nsdae_monitors *w = &point->accounts.watch;
  const nsdae_record *r = &point->record;
  int new = ~point->accounts.stats.warnings;
  const double *moved = point->result.counters.moved ? sim->slop.moved : NULL;
  if (point->result.counters.inexact) point->accounts.stats.warnings |= NSDAE_MONITORS_CONTACT;
  measure_lengths(w, &before->result.end, &point->result, moved);
  excess all[3] = {find_gain(w, before, point)};
  int status = judge_fallback(sim, before, point), found = 1;
  if (status == NSDAE_OK) status = judge_growth(sim, point);
  if (status == NSDAE_OK) status = judge_spin(sim, before, point, new);
  if (status != NSDAE_OK) return status;
  if (r->penetration > nsdae_terms_touch(&point->result.end))
    all[found++] = deepest(sim, before, point);
  if (r->constraint_drift > 0) all[found++] = furthest(point);
  for (int i = 0; i < found; i++)
    if (all[i].value > all[i].bound && (new &bit_of(rules[all[i].rule].status))) {
      if (all[i].rule == OF_STEPS)
        w->reported =
            fmax(all[i].bound,
                 energy_of_forces(&before->result.end, point->result.end.t - before->result.end.t));
      return report(point, &all[i], rules[all[i].rule].status);
    }
  status = judge_tunnelling(sim, before, point, new);
  if (status == NSDAE_OK) status = judge_law(sim, point);
  if (status == NSDAE_OK) status = judge_unresolved(sim, point, new);
  if (status == NSDAE_OK) status = judge_residual(sim, point, new);
  if (status == NSDAE_OK) status = judge_singular(point, new);
  if (status != NSDAE_OK) return status;
  const nsdae_twofold *of = &point->result.twofold;
  const nsdae_terms *end = &point->result.end;
  char called[NSDAE_CALLED_SIZE];
  if (of->frictional_joint < 0 || !(new &NSDAE_MONITORS_PAINLEVE))
    return new &NSDAE_MONITORS_IMPACTS ? nsdae_merged_report(sim, before, point) : NSDAE_OK;
  point->accounts.stats.warnings |= NSDAE_MONITORS_PAINLEVE;
  nsdae_error_set(
      end->error, NSDAE_WARN_PAINLEVE, "nsdae_sim", "mu",
      "%s has two solutions for its friction at t = %.6g (Painleve): the one of the multiplier "
      "%.6g is used; a smaller mu makes it unique",
      nsdae_system_called(end->system, NSDAE_NAME_FRICTIONAL_JOINT, of->frictional_joint, called),
      of->t, of->lambda);
  return nsdae_error_at(end->error, NSDAE_WARN_PAINLEVE, of->frictional_joint, of->t);
}
