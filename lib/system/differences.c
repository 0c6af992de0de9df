#include "differences.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Contacts that have a number in the callbacks. */
static int fixed_contacts(const nsdae_system *s)
{
  return s->tracked ? 0 : s->dims.k;
}

/* Of the contacts in slots, and the lists that they are in. */
static void lay_out_slots(nsdae_differences *d, nsdae_arena *arena)
{
  const nsdae_system *s = d->system;
  long k = s->tracked ? NSDAE_BY_ID_POINTS * s->dims.k : 0;
  d->by_id.list.blocks = &s->blocks;
  d->by_id.list.nt = s->dims.nt;
  d->by_id.velocity = NSDAE_ARENA_DOUBLES(arena, k * (1 + s->dims.nt));
  d->by_id.listed = NSDAE_ARENA_INTS(arena, k);
}

void nsdae_differences_layout(nsdae_differences *differences, nsdae_arena *arena)
{
  const nsdae_dims *dims = &differences->system->dims;
  long k = fixed_contacts(differences->system), rows = dims->m > k ? dims->m : k;
  differences->finer[0] = differences->finer[1] = 0;
  nsdae_arena_doubles(
      arena, dims->nq,
      (double **[]){&differences->q, &differences->qdot, &differences->centre, NULL});
  differences->unit = NSDAE_ARENA_DOUBLES(arena, dims->nv);
  nsdae_arena_doubles(
      arena, rows,
      (double **[]){&differences->plus, &differences->minus, &differences->rate, NULL});
  long kt = k * dims->nt, entries = dims->nv * (kt > k ? kt : k);
  long joints = differences->system->call.joint_friction_rows ? dims->f : (long)dims->nv * dims->f;
  if (joints > entries) entries = joints;
  differences->moved = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  differences->W = NSDAE_ARENA_DOUBLES(arena, entries);
  differences->velocity = NSDAE_ARENA_DOUBLES(arena, k + kt + dims->f);
  for (int i = 0; i < 2; i++)
    differences->tuned[i] =
        NSDAE_ARENA_DOUBLES(arena, dims->m + dims->k * (1L + dims->nt) + dims->f);
  lay_out_slots(differences, arena);
}

/* Halves of a step that tune tries: scales of motion down to 1 / 512 of a unit. */
enum { FINEST = 9 };

/* A power of two, so that t + s and t - s are exact. Neither time nor place has a natural zero, so
 * that the step grows with them for rounding alone: scale = eps^p is the best step of a function
 * with errors eps, and far out they are eps (1 + |q|), whatever else moves with it; at late times
 * they are eps |t|. */
double nsdae_differences_step(int nq, double t, const double *q, const double *qdot, double scale)
{
  double p = ilogb(scale) / (1.0 - DBL_MANT_DIG), far = 0, fastest;
  for (int i = 0; i < nq; i++) far = fmax(far, qdot[i] != 0 ? fabs(q[i]) : 0);
  double late = fabs(t) > 1e4 ? fabs(t) : 0;
  fastest = 1 / ldexp(1, (int)(p * ilogb(1 + fmax(far, late))));
  for (int i = 0; i < nq; i++)
    fastest = fmax(fastest, ldexp(fabs(qdot[i]), -(int)(p * ilogb(1 + fabs(q[i])))));
  return ldexp(1, ilogb(scale / fastest));
}

static int kinematics(nsdae_differences *d, double t, const double *q, const double *v,
                      double *qdot)
{
  int code = nsdae_kinematics(d->system, t, q, v, qdot);
  if (code) d->failed = "kinematics";
  return code;
}

/* f(t + time s, q + s qdot) */
static int displaced(nsdae_differences *d, nsdae_position_fn f, double t, const double *q, double s,
                     double time, double *value)
{
  for (int i = 0; i < d->system->dims.nq; i++) d->q[i] = q[i] + s * d->qdot[i];
  return f(t + time * s, d->q, value, d->system->user);
}

/* f' of the motion d->qdot; time = 0 leaves out f_t */
static int difference_rate(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                           const double *q, double time, double *out)
{
  double s = nsdae_differences_step(d->system->dims.nq, time * t, q, d->qdot,
                                    ldexp(cbrt(DBL_EPSILON), -d->finer[0]));
  int code = displaced(d, f, t, q, s, time, d->plus);
  if (!code) code = displaced(d, f, t, q, -s, time, d->minus);
  for (int i = 0; i < rows; i++) out[i] = (d->plus[i] - d->minus[i]) / (2 * s);
  return code;
}

int nsdae_differences_velocity(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                               const double *q, double *D, int ldd, int transposed)
{
  int nv = d->system->dims.nv, code = 0;
  d->failed = NULL;
  for (int j = 0; j < nv && !code; j++) {
    memset(d->unit, 0, (size_t)nv * sizeof *d->unit);
    d->unit[j] = 1;
    code = kinematics(d, t, q, d->unit, d->qdot);
    if (!code) code = difference_rate(d, f, rows, t, q, 0, d->rate);
    for (int i = 0; i < rows; i++) {
      size_t at =
          transposed ? (size_t)i * (size_t)ldd + (size_t)j : (size_t)j * (size_t)ldd + (size_t)i;
      D[at] = d->rate[i];
    }
  }
  return code;
}

int nsdae_differences_along(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                            const double *q, const double *v, double *along)
{
  d->failed = NULL;
  int code = kinematics(d, t, q, v, d->qdot);
  return code ? code : difference_rate(d, f, rows, t, q, 0, along);
}

int nsdae_differences_time(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                           const double *q, double *f_t)
{
  d->failed = NULL;
  memset(d->qdot, 0, (size_t)d->system->dims.nq * sizeof *d->qdot);
  return difference_rate(d, f, rows, t, q, 1, f_t);
}

/* d->moved := q(t + s) of dq/dt = H(t,q) v with v constant, by the classical method of Runge and
 * Kutta: its error s^5 is odd in s except s^6. */
static int carry(nsdae_differences *d, double t, const double *q, const double *v, double s)
{
  static const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  int nq = d->system->dims.nq, stages = d->system->call.kinematics ? 4 : 1, code = 0;
  memcpy(d->moved, q, (size_t)nq * sizeof *q);
  for (int stage = 0; stage < stages && !code; stage++) {
    double ahead = at[stage] * s, part = stages == 1 ? s : weight[stage] * s;
    for (int i = 0; i < nq; i++) d->centre[i] = stage > 0 ? q[i] + ahead * d->qdot[i] : q[i];
    code = kinematics(d, t + ahead, d->centre, v, d->qdot);
    for (int i = 0; i < nq; i++) d->moved[i] += part * d->qdot[i];
  }
  return code;
}

int nsdae_differences_second(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                             const double *q, const double *v, double *omega)
{
  /* f'' = (16 (f(s) + f(-s)) - (f(2s) + f(-2s)) - 30 f(0)) / 12 s^2 + O(s^4); rounding eps / s^2:
   * s ~ eps^(1/6) */
  static const double at[5] = {0, -2, -1, 1, 2}, weight[5] = {-30, -1, 16, 16, -1};
  d->failed = NULL;
  int code = kinematics(d, t, q, v, d->qdot);
  double s = nsdae_differences_step(d->system->dims.nq, t, q, d->qdot, ldexp(5e-3, -d->finer[1]));
  memset(omega, 0, (size_t)rows * sizeof *omega);
  for (int j = 0; j < 5 && !code; j++) {
    code = carry(d, t, q, v, at[j] * s);
    if (!code) code = f(t + at[j] * s, d->moved, d->plus, d->system->user);
    for (int i = 0; i < rows; i++) omega[i] += weight[j] / (12 * s * s) * d->plus[i];
  }
  return code;
}

int nsdae_differences_bend(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                           const double *q, const double *v, double *bend)
{
  /* (f(s) - 2 f(0) + f(-s)) / s^2 is a mean of f'' with weights that are not negative: where f''
   * jumps it is between its values, which five points are not */
  d->failed = NULL;
  int code = kinematics(d, t, q, v, d->qdot);
  double s = nsdae_differences_step(d->system->dims.nq, t, q, d->qdot, ldexp(1e-3, -d->finer[1]));
  memset(bend, 0, (size_t)rows * sizeof *bend);
  for (int j = -1; j <= 1 && !code; j++) {
    code = carry(d, t, q, v, j * s);
    if (!code) code = f(t, d->moved, d->plus, d->system->user);
    for (int i = 0; i < rows; i++) bend[i] += (j ? 1 : -2) / (s * s) * d->plus[i];
  }
  return code;
}

/* Ends an evaluation of a callback: remembers its name where it failed or its velocities are not
 * finite. */
static int judge(nsdae_differences *d, int code, const char *callback, int count, const double *u)
{
  if (code && !d->failed) d->failed = callback;
  for (int i = 0; i < count && !d->bad; i++)
    if (!isfinite(u[i])) d->bad = callback;
  return code;
}

/* d->W, zero: a callback's directions. */
static double *no_directions(nsdae_differences *d, int columns)
{
  return memset(d->W, 0, (size_t)d->system->dims.nv * (size_t)columns * sizeof *d->W);
}

/* u += W^T v after the callback gave W. */
static int add_velocities(nsdae_differences *d, int code, const char *callback, int columns,
                          const double *v, double *u)
{
  if (!code) nsdae_add_transposed(d->system->dims.nv, columns, 1, d->W, v, u);
  return judge(d, code, callback, columns, u);
}

/* w_N and w_T into the velocities. */
static int contact_offsets(nsdae_differences *d, double t, const double *q, double *u_n,
                           double *u_t)
{
  const nsdae_system *s = d->system;
  int k = fixed_contacts(s), nt = s->dims.nt;
  if (k == 0 || (!s->call.contact_bias && !s->call.gap_normal)) return 0;
  if (!s->call.contact_bias)
    return judge(d, nsdae_differences_time(d, s->call.gap, k, t, q, u_n), "gap", k, u_n);
  int code = s->call.contact_bias(t, q, u_n, nt > 0 ? u_t : NULL, s->user);
  judge(d, code, "contact_bias", k * nt, u_t);
  return judge(d, code, "contact_bias", k, u_n);
}

/* u [f] += W_S^T v + w_S, W_S by rows. */
static int add_joint_rows(nsdae_differences *d, double t, const double *q, const double *v,
                          double *u)
{
  const nsdae_system *s = d->system;
  nsdae_rows rows = {.count = s->dims.f};
  nsdae_row_list list = {.system = s,
                         .blocks = &s->blocks,
                         .kind = NSDAE_NAME_FRICTIONAL_JOINT,
                         .rows = &rows,
                         .x = v,
                         .product = d->W};
  nsdae_row_list_clear(&list);
  memset(d->W, 0, (size_t)rows.count * sizeof *d->W);
  int code = s->call.joint_friction_rows(t, q, &list, u, s->user);
  if (!code && list.status < 0) code = -1;
  nsdae_add(rows.count, 1, d->W, u);
  return judge(d, code, "joint_friction_rows", rows.count, u);
}

/* u: of contacts along the normal (unless W_N is of differences) and the
 * tangents, and of frictional joints. */
static int add_all_velocities(nsdae_differences *d, double t, const double *q, const double *v,
                              double *const u[3])
{
  const nsdae_system *s = d->system;
  const nsdae_calls *call = &s->call;
  int n = s->dims.nv, k = fixed_contacts(s), kt = k * s->dims.nt, f = s->dims.f;
  int code = contact_offsets(d, t, q, u[0], u[1]);
  if (!code && k > 0 && call->gap_normal)
    code = add_velocities(d, call->gap_normal(t, q, no_directions(d, k), n, s->user), "gap_normal",
                          k, v, u[0]);
  if (!code && kt > 0 && call->gap_tangent)
    code = add_velocities(d, call->gap_tangent(t, q, no_directions(d, kt), n, s->user),
                          "gap_tangent", kt, v, u[1]);
  if (code || f == 0) return code;
  if (call->joint_friction_rows) return add_joint_rows(d, t, q, v, u[2]);
  if (!call->frictional_joint_tangent) return 0;
  code = call->frictional_joint_tangent(t, q, no_directions(d, f), n, u[2], s->user);
  return add_velocities(d, code, "frictional_joint_tangent", f, v, u[2]);
}

/* omega += weight u(t + s, q + s H v) */
static int add_displaced(nsdae_differences *d, double t, const double *q, const double *v, double s,
                         double weight, double *const omega[3])
{
  const nsdae_dims *dims = &d->system->dims;
  int k = fixed_contacts(d->system), size[3] = {k, k * dims->nt, dims->f};
  double *u[3] = {d->velocity, d->velocity + size[0], d->velocity + size[0] + size[1]};
  int code = kinematics(d, t, q, v, d->qdot);
  for (int i = 0; i < dims->nq; i++) d->moved[i] = q[i] + s * d->qdot[i];
  memset(d->velocity, 0, (size_t)(size[0] + size[1] + size[2]) * sizeof *d->velocity);
  if (!code) code = add_all_velocities(d, t + s, d->moved, v, u);
  for (int part = 0; part < 3; part++)
    for (int i = 0; i < size[part]; i++) omega[part][i] += weight * u[part][i];
  return code;
}

double nsdae_differences_acceleration_step(const nsdae_differences *d, double t, const double *q)
{
  return nsdae_differences_step(d->system->dims.nq, t, q, d->qdot, ldexp(7.4e-4, -d->finer[1]));
}

int nsdae_differences_contacts(nsdae_differences *d, double t, const double *q, const double *v,
                               double *omega_n, double *omega_t, double *omega_s)
{
  /* u' = (8 (u(s) - u(-s)) - (u(2s) - u(-2s))) / 12 s + O(s^4); rounding eps / s: s ~ eps^(1/5) */
  static const double at[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
  double *const omega[3] = {omega_n, omega_t, omega_s};
  const nsdae_dims *dims = &d->system->dims;
  int k = fixed_contacts(d->system);
  d->failed = d->bad = NULL;
  memset(omega_n, 0, (size_t)k * sizeof *omega_n);
  memset(omega_t, 0, (size_t)(k * dims->nt) * sizeof *omega_t);
  memset(omega_s, 0, (size_t)dims->f * sizeof *omega_s);
  int code = kinematics(d, t, q, v, d->qdot);
  double s = nsdae_differences_acceleration_step(d, t, q);
  for (int i = 0; i < 4 && !code; i++)
    code = add_displaced(d, t, q, v, at[i] * s, weight[i] / (12 * s), omega);
  const nsdae_calls *call = &d->system->call;
  if (code || k == 0 || call->gap_normal) return code;
  /* Where W_N is of differences too, g'' of the gap itself: another difference of those would have
   * their error over its step. */
  code = nsdae_differences_second(d, call->gap, k, t, q, v, omega_n);
  return judge(d, code, "gap", k, omega_n);
}

static int rates_used(const nsdae_system *s)
{
  return (s->dims.m > 0 && !(nsdae_system_has_jacobian(s) && s->call.constraint_bias)) ||
         (fixed_contacts(s) > 0 && !(s->call.gap_normal && s->call.contact_bias));
}

static int accelerations_used(const nsdae_system *s)
{
  return (s->dims.m > 0 && !s->call.constraint_bias) ||
         (s->dims.k + s->dims.f > 0 && !s->call.contact_acceleration);
}

int nsdae_differences_used(const nsdae_system *s)
{
  return rates_used(s) || accelerations_used(s);
}

/* rate [rows] of f: along the motion without its derivatives by q, in time without those by t. */
static int rates_of(nsdae_differences *d, nsdae_position_fn f, int rows, double t, const double *q,
                    const double *v, int along, int in_time, double *out)
{
  int code = 0;
  memset(out, 0, (size_t)rows * sizeof *out);
  if (along) code = nsdae_differences_along(d, f, rows, t, q, v, out);
  if (code || !in_time) return code;
  code = nsdae_differences_time(d, f, rows, t, q, d->rate);
  nsdae_add(rows, 1, d->rate, out);
  return code;
}

/* out [m + k]: of constraints and gaps, what has no formula. */
static int rates(nsdae_differences *d, double t, const double *q, const double *v, double *out)
{
  const nsdae_system *s = d->system;
  int m = s->dims.m, k = fixed_contacts(s), code = 0;
  d->failed = NULL;
  if (m > 0)
    code = rates_of(d, s->call.constraint, m, t, q, v, !nsdae_system_has_jacobian(s),
                    !s->call.constraint_bias, out);
  judge(d, code, "constraint", 0, NULL);
  if (code || k == 0) return code;
  code = rates_of(d, s->call.gap, k, t, q, v, !s->call.gap_normal, !s->call.contact_bias, out + m);
  return judge(d, code, "gap", 0, NULL);
}

/* omega [m + k + k nt + f]: of what has no formula, zero of the rest. */
static int accelerations(nsdae_differences *d, double t, const double *q, const double *v,
                         double *omega)
{
  const nsdae_system *s = d->system;
  const nsdae_dims *dims = &s->dims;
  double *normal = omega + dims->m, *tangential = normal + dims->k;
  int code = 0;
  memset(omega, 0, (size_t)(dims->m + dims->k * (1 + dims->nt) + dims->f) * sizeof *omega);
  if (dims->m > 0 && !s->call.constraint_bias)
    code = judge(d, nsdae_differences_second(d, s->call.constraint, dims->m, t, q, v, omega),
                 "constraint", 0, NULL);
  if (!code && s->tracked) code = nsdae_differences_by_id(d, t, q, v, normal, tangential);
  if (!code && fixed_contacts(s) + dims->f > 0 && !s->call.contact_acceleration)
    code =
        nsdae_differences_contacts(d, t, q, v, normal, tangential, tangential + dims->k * dims->nt);
  return code;
}

/* What tune tries with a finer and finer step: `rates` or `accelerations`. */
typedef int (*derivative)(nsdae_differences *d, double t, const double *q, const double *v,
                          double *out);

static int tune(nsdae_differences *d, derivative evaluate, int rows, double t, const double *q,
                const double *v, int *finer, double *error)
{
  int best = 0;
  *error = INFINITY;
  *finer = 0;
  int code = evaluate(d, t, q, v, d->tuned[0]);
  for (int i = 1; i <= FINEST && !code; i++) {
    double change = 0, *coarse = d->tuned[1 - i % 2], *fine = d->tuned[i % 2];
    *finer = i;
    code = evaluate(d, t, q, v, fine);
    for (int j = 0; j < rows; j++) change = fmax(change, fabs(fine[j] - coarse[j]));
    if (!(change < *error)) {
      best -= change > 2 * *error; /* rounding rules: the coarser of the two has less of it */
      break;
    }
    *error = change;
    best = i;
  }
  *finer = best;
  if (!isfinite(*error))
    *error = 0; /* a callback failed: the evaluation that needs its value reports it */
  return code;
}

int nsdae_differences_tune(nsdae_differences *d, double t, const double *q, const double *v,
                           double *error)
{
  const nsdae_dims *dims = &d->system->dims;
  int code = 0;
  error[0] = error[1] = 0;
  d->finer[0] = d->finer[1] = 0;
  if (rates_used(d->system))
    code = tune(d, rates, dims->m + fixed_contacts(d->system), t, q, v, &d->finer[0], &error[0]);
  if (!code && accelerations_used(d->system))
    code = tune(d, accelerations, dims->m + dims->k * (1 + dims->nt) + dims->f, t, q, v,
                &d->finer[1], &error[1]);
  return code;
}

/* Rates of the velocities u = W^T v + w of listed contacts along the motion with v constant, by id:
 *
 *   u' = (8 (u(s) - u(-s)) - (u(2s) - u(-2s))) / 12 s + O(s^4),
 *
 * and of a contact that is not listed at all of the points: (u(s) - u(-s)) / 2 s + O(s^2), or, on
 * one side, (4 u(s) - u(2s) - 3 u(0)) / 2 s + O(s^2). */

enum { POINTS = NSDAE_BY_ID_POINTS, CENTRE = 0 };

/* Point 0 is the centre. */
static const int at[POINTS] = {0, -2, -1, 1, 2};

int nsdae_differences_grow(nsdae_differences *d, const nsdae_room *contacts, nsdae_error *error)
{
  d->by_id.list.error = error;
  return d->system->tracked ? nsdae_contact_list_grow(&d->by_id.list, contacts) : NSDAE_OK;
}

int nsdae_differences_status(nsdae_differences *d, int code, const char *callback, double t,
                             nsdae_error *error)
{
  int of_list = d->by_id.status;
  d->by_id.status = NSDAE_OK;
  if (code < 0 && code == of_list && d->failed && strcmp(d->failed, "contacts") == 0) {
    if (error && code != NSDAE_ARRAYS_GROW) error->time = t;
    return code;
  }
  return nsdae_system_callback_status(code, d->failed ? d->failed : callback, t, error);
}

/* The list at t + s, q + s qdot, in by_id.list. */
static int list_at(nsdae_differences *d, double t, const double *q, const double *v, double s,
                   double reach)
{
  const nsdae_system *system = d->system;
  nsdae_contact_list *list = &d->by_id.list;
  for (int i = 0; i < system->dims.nq; i++) d->moved[i] = q[i] + s * d->qdot[i];
  nsdae_contact_list_clear(list);
  int code = system->call.contacts(t + s, d->moved, v, reach, list, system->user);
  int grows = nsdae_differences_room(d, 0, &list->room, &list->taken);
  d->by_id.status = list->status < 0 ? list->status : code ? NSDAE_OK : grows;
  if (code || d->by_id.status < 0) d->failed = "contacts";
  return d->by_id.status < 0 ? d->by_id.status : code;
}

/* Velocities of the slots at a point, of those that do not give omega; the fastest along a normal
 * in *fastest. */
static void read_velocities(nsdae_differences *d, int point, const double *v, double *fastest)
{
  const nsdae_system *s = d->system;
  const nsdae_contact_list *list = &d->by_id.list;
  int k = s->dims.k, rows = 1 + s->dims.nt, *listed = d->by_id.listed + point * k;
  double *u = d->by_id.velocity + (size_t)point * (size_t)(k * rows);
  memset(listed, 0, (size_t)k * sizeof *listed);
  for (int i = 0, slot = -1; i < list->count; i++) {
    int found = nsdae_tracked_find(s->tracked, k, list->id[i], slot + 1);
    if (found >= 0) slot = found;
    if (found < 0 || list->omega_given[i]) continue;
    listed[slot] = 1;
    for (int j = 0; j < rows; j++) u[slot * rows + j] = nsdae_contact_list_velocity(list, i, j, v);
    *fastest = fmax(*fastest, fabs(u[slot * rows]));
  }
}

static int not_listed(nsdae_differences *d, int slot, double t, double s)
{
  char called[NSDAE_CALLED_SIZE];
  d->by_id.status = nsdae_error_set(
      d->by_id.list.error, NSDAE_E_CALLBACK, "nsdae_sim", "contacts",
      "contacts lists %s at t = %g, but not %g before and after along the motion: its "
      "acceleration at v' = 0 is unknown; list it, or set omega and omega_given",
      nsdae_system_called_id(d->system, d->system->tracked->id[slot], called), t, s);
  d->failed = "contacts";
  return d->by_id.status;
}

/* The weights of the points for u' s of a contact that is listed at some of them; whether there are
 * such. */
static int choose(const int *listed, int k, const double **weight)
{
  static const double all[POINTS] = {0, 1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12},
                      near[POINTS] = {0, 0, -0.5, 0.5, 0}, ahead[POINTS] = {-1.5, 0, 0, 2, -0.5},
                      back[POINTS] = {1.5, 0.5, -2, 0, 0};
  int m2 = listed[k], m1 = listed[2 * k], p1 = listed[3 * k], p2 = listed[4 * k];
  *weight = m1 && p1 ? (m2 && p2 ? all : near) : p1 && p2 ? ahead : back;
  return (m1 && p1) || (p1 && p2) || (m1 && m2);
}

int nsdae_differences_by_id(nsdae_differences *d, double t, const double *q, const double *v,
                            double *omega_n, double *omega_t)
{
  const nsdae_system *system = d->system;
  int k = system->dims.k, nt = system->dims.nt, rows = 1 + nt, any = 0;
  double fastest = 0, unused = 0;
  const double *weight;
  memset(omega_n, 0, (size_t)k * sizeof *omega_n);
  memset(omega_t, 0, (size_t)(k * nt) * sizeof *omega_t);
  d->failed = NULL;
  d->by_id.status = NSDAE_OK;
  int code = nsdae_kinematics(system, t, q, v, d->qdot);
  if (code) d->failed = "kinematics";
  double s = nsdae_differences_acceleration_step(d, t, q);
  if (!code) code = list_at(d, t, q, v, 0, system->tracked->reach);
  if (!code) read_velocities(d, CENTRE, v, &fastest);
  for (int i = 0; i < k && !code; i++) any |= d->by_id.listed[i];
  for (int point = 1; point < POINTS && any && !code; point++) {
    code = list_at(d, t, q, v, at[point] * s, system->tracked->reach + 4 * fabs(s) * fastest);
    if (!code) read_velocities(d, point, v, &unused);
  }
  for (int i = 0; i < k && any && !code; i++) {
    if (!d->by_id.listed[i]) continue;
    if (!choose(d->by_id.listed + i, k, &weight)) return not_listed(d, i, t, s);
    for (int j = 0; j < rows; j++) {
      double *omega = j == 0 ? &omega_n[i] : &omega_t[i * nt + j - 1], sum = 0;
      for (int point = 0; point < POINTS; point++)
        if (weight[point] != 0)
          sum += weight[point] * d->by_id.velocity[(point * k + i) * rows + j];
      *omega = sum / s;
    }
  }
  return code;
}
