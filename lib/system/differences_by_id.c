/* Rates of the velocities u = W^T v + w of listed contacts along the motion with v constant, by id:
 *
 *   u' = (8 (u(s) - u(-s)) - (u(2s) - u(-2s))) / 12 s + O(s^4),
 *
 * and of a contact that is not listed at all of the points: (u(s) - u(-s)) / 2 s + O(s^2), or, on
 * one side, (4 u(s) - u(2s) - 3 u(0)) / 2 s + O(s^2). */
#include <math.h>
#include <string.h>

#include "differences.h"
#include "errors.h"

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
      "contacts lists %s at t = %.17g, but not %g before and after along the motion: its "
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
