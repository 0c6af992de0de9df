/* Arms of rotations in W_T, in space, as far as the gap and the kinematics tell.
 *
 * Three velocities w that move four coordinates e as an angular velocity moves a quaternion (the
 * columns of de/dt = H w are at right angles to e and to each other, and |e| / 2 long) turn a body.
 * With r from its centre to where it touches, the columns n, t_1, t_2 of W along its translations
 * and a, b_1, b_2 along its rotations are, in axes that C turns into those of the translations,
 *
 *   a = C^T (r x n),  b_j = C^T (r x t_j):   C (a n^T + b_1 t_1^T + b_2 t_2^T) = [r x],
 *
 * skew-symmetric, for n, t_1, t_2 are at right angles. C is 1 or the rotation of e, which has its
 * scalar first or last, one way or the other: the same at all contacts of the body. And a turn
 * about the point of contact, at right angles to n, opens the gap by
 *
 *   v^T H v <= -r . n
 *
 * (see moment_arms.h, where the sense of a rotation is not known; here it is), which a ball's arms
 * with the other sign break. Which velocities turn which body is guessed, so this is a doubt, too.
 */
#include "moment_arms.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "system_impl.h"
#include "vector.h"

enum { FRAMES = 5, BODIES = 2 };

/* Three velocities that turn a body, from `first` on, and what C may be. */
typedef struct turner {
  int first;
  double C[FRAMES][3][3];
} turner;

/* Of the quaternion w, x, y, z. */
static void rotation_of(double w, double x, double y, double z, double R[3][3])
{
  const double s = 2 / (w * w + x * x + y * y + z * z);
  const double rows[3][3] = {{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
                             {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
                             {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}};
  memcpy(R, rows, sizeof rows);
}

/* Whether velocities j, j + 1, j + 2 turn a body, and the coordinates that they move; a callback's
 * code is kept. */
static int find_turned(const nsdae_moment_arms *arms, int j, double *H, int at[4], int *code)
{
  const nsdae_system *s = arms->all.system;
  int nq = s->dims.nq;
  double column[4][4]; /* of 2 H, and e */
  for (int l = 0; l < 3 && *code == 0; l++) {
    memset(arms->v, 0, (size_t)s->dims.nv * sizeof *arms->v);
    memset(H + l * nq, 0, (size_t)nq * sizeof *H);
    arms->v[j + l] = 1;
    *code = nsdae_kinematics(s, arms->t, arms->q, arms->v, H + l * nq);
  }
  if (*code) arms->differences->failed = "kinematics";
  int count = 0; /* of coordinates that three columns of H move: four */
  for (int i = 0; i < nq && *code == 0; i++) {
    if (H[i] == 0 && H[nq + i] == 0 && H[2 * nq + i] == 0) continue;
    if (count < 4) at[count] = i;
    count++;
  }
  if (count != 4) return 0;
  for (int i = 0; i < 4; i++) {
    column[3][i] = arms->q[at[i]];
    for (int l = 0; l < 3; l++) column[l][i] = 2 * H[l * nq + at[i]];
  }
  double size = nsdae_dot(4, column[3], column[3]);
  for (int k = 0; k < 4; k++)
    for (int l = 0; l < 4; l++)
      if (!(fabs(nsdae_dot(4, column[k], column[l]) - (k == l ? size : 0)) <= 1e-9 * size))
        return 0;
  return size > 0;
}

static int read_turner(const nsdae_moment_arms *arms, int j, double *H, turner *t, int *code)
{
  int at[4];
  if (!find_turned(arms, j, H, at, code)) return 0;
  const double e[4] = {arms->q[at[0]], arms->q[at[1]], arms->q[at[2]], arms->q[at[3]]};
  *t = (turner){.first = j, .C = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  rotation_of(e[0], e[1], e[2], e[3], t->C[1]);
  rotation_of(e[3], e[0], e[1], e[2], t->C[3]);
  for (int f = 1; f < FRAMES; f += 2)
    for (int i = 0; i < 9; i++) t->C[f + 1][i / 3][i % 3] = t->C[f][i % 3][i / 3];
  return 1;
}

int nsdae_moment_arm_check_unit(const nsdae_moment_arms *arms, double *H, double *q)
{
  const nsdae_dims *d = &arms->all.system->dims;
  int at[4], code = 0;
  for (int j = 0; j + 2 < d->nv && d->nq > d->nv && code == 0; j++) {
    if (!find_turned(arms, j, H, at, &code)) continue;
    double sum = 0;
    for (int i = 0; i < 4; i++) sum += q[at[i]] * q[at[i]];
    for (int i = 0; i < 4; i++) q[at[i]] /= sqrt(sum);
  }
  return code;
}

/* Column j of n, t_1, t_2. */
static const double *direction_column(const nsdae_contact_directions *c, int j)
{
  return j == 0 ? c->normal : c->tangent + (size_t)(j - 1) * (size_t)c->nv;
}

static int touches(const nsdae_contact_directions *c, int first)
{
  int any = 0;
  for (int j = 0; j < 3; j++)
    for (int i = first; i < first + 3; i++) any |= direction_column(c, j)[i] != 0;
  return any;
}

/* The first translation of the body that `first` turns, and that slides at the contact; -1: none
 * does. Bodies and what turns them are in one order. */
static int find_translation(const nsdae_contact_directions *c, const int *turns, int first,
                            double tol)
{
  int along[BODIES], bodies = 0, rotations = 0, number = -1;
  for (int of = 0; of < c->nv; of++) {
    if (!nsdae_tangent_translates(c, of, of, tol)) continue;
    if (bodies == BODIES) return -1;
    along[bodies++] = of;
  }
  for (int j = 0; j + 2 < c->nv; j++) {
    if (!turns[j] || !touches(c, j)) continue;
    if (j == first) number = rotations;
    rotations++;
  }
  return rotations == bodies && number >= 0 ? along[number] : -1;
}

/* A contact of a body that is turned. */
typedef struct lever {
  int contact, of, first;                   /* the first of the translations, of the rotations */
  double along[3][3], about[3][3], C[3][3]; /* n, t_1, t_2; a, b_1, b_2 */
} lever;

static int read_lever(const nsdae_moment_arms *arms, const int *turns, int first, int i, double tol,
                      lever *l)
{
  const nsdae_contact_directions c = nsdae_tangent_contact(&arms->all, i);
  *l = (lever){.contact = i, .first = first};
  if (!(c.system->contact[i].mu > 0) || !touches(&c, first)) return 0;
  int of = find_translation(&c, turns, first, tol), axis = 0;
  for (int k = of; of >= 0 && k < c.nv; k++) {
    if (!nsdae_tangent_translates(&c, of, k, tol)) continue;
    for (int j = 0; j < 3; j++) l->along[j][axis] = direction_column(&c, j)[k];
    axis++;
  }
  for (int j = 0; j < 3; j++)
    memcpy(l->about[j], direction_column(&c, j) + first, 3 * sizeof(double));
  double sum = 0;
  for (int j = 1; j < 3; j++) sum += nsdae_dot(3, l->along[j], l->along[j]);
  l->of = of;
  return of >= 0 && fabs(sum - 2) <= tol; /* slides on it in both directions */
}

/* r of [r x], and how far what should be [r x] is from a skew-symmetric matrix. */
static double read_radius(const lever *l, double r[3])
{
  double B[3][3] = {{0}}, most = 0;
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < 3; j++) B[i][k] += nsdae_dot(3, l->C[i], l->about[j]) * l->along[j][k];
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) most = fmax(most, fabs(B[i][k] + B[k][i]));
  for (int i = 0; i < 3; i++) {
    int k = (i + 1) % 3, m = (i + 2) % 3;
    r[i] = (B[m][k] - B[k][m]) / 2;
  }
  return most / (1 + nsdae_largest(3, r));
}

/* Whether such a turn opens the gap more than r lets it. */
static int find_excess(nsdae_moment_arms *arms, const lever *l, const double r[3], int j,
                       double tol, int *any)
{
  double small = 100 * tol * (1 + nsdae_largest(3, r)), bend;
  /* A turn about the contact along direction j, into arms->v. */
  double w[3] = {0};
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 3; i++) w[k] += l->C[i][k] * l->along[j][i];
  const nsdae_contact_directions c = nsdae_tangent_contact(&arms->all, l->contact);
  memset(arms->v, 0, (size_t)c.nv * sizeof *arms->v);
  for (int k = 0; k < 3; k++) /* W_N v = W_T v = 0 */
    for (int i = 0; i < c.nv; i++)
      if (nsdae_tangent_translates(&c, l->of, i, tol))
        arms->v[i] -= nsdae_dot(3, l->about[k], w) * direction_column(&c, k)[i];
  memcpy(arms->v + l->first, w, sizeof w);
  int code = nsdae_moment_arms_bend(arms, l->contact, &bend);
  *any = bend + nsdae_dot(3, r, l->along[0]) > small;
  return code || !*any ? code : nsdae_moment_arms_bends(arms, l->contact, bend, small, any);
}

static int doubt_sense(nsdae_moment_arms *arms, const lever *l, const double r[3], double tol,
                       char *text, size_t size)
{
  char contact[NSDAE_CALLED_SIZE], velocity[NSDAE_CALLED_SIZE];
  for (int j = 1; j < 3; j++) {
    int any;
    int code = find_excess(arms, l, r, j, tol, &any);
    if (code) return code;
    if (!any) continue;
    snprintf(text, size,
             "gap_tangent: the signs of its arms of %s along %s and the next two, if these rotate "
             "the body: a rotation about the contact would open the gap",
             nsdae_system_called(arms->all.system, NSDAE_NAME_CONTACT, l->contact, contact),
             nsdae_system_called(arms->all.system, NSDAE_NAME_VELOCITY, l->first, velocity));
    return 0;
  }
  return 0;
}

/* In the frame that most contacts are right in. */
static int doubt_body(nsdae_moment_arms *arms, const int *turns, const turner *t, double tol,
                      char *text, size_t size)
{
  char contact[NSDAE_CALLED_SIZE], velocity[NSDAE_CALLED_SIZE];
  int best = 0, most = -1, code = 0, k = arms->all.system->dims.k;
  double r[3];
  lever l;
  for (int f = 0; f < FRAMES; f++) {
    int count = 0; /* of contacts that have arms of one point each in this frame */
    for (int i = 0; i < k; i++) {
      if (!read_lever(arms, turns, t->first, i, tol, &l)) continue;
      memcpy(l.C, t->C[f], sizeof l.C);
      count += read_radius(&l, r) <= 10 * tol;
    }
    if (count > most) best = f, most = count;
  }
  for (int i = 0; i < k && code == 0 && !*text; i++) {
    if (!read_lever(arms, turns, t->first, i, tol, &l)) continue;
    memcpy(l.C, t->C[best], sizeof l.C);
    if (read_radius(&l, r) <= 10 * tol)
      code = doubt_sense(arms, &l, r, tol, text, size);
    else
      snprintf(text, size,
               "gap_tangent: its arms of %s along %s and the next two, if these rotate the body: "
               "they and those of the normal are not r x t and r x n of one point",
               nsdae_system_called(arms->all.system, NSDAE_NAME_CONTACT, i, contact),
               nsdae_system_called(arms->all.system, NSDAE_NAME_VELOCITY, t->first, velocity));
  }
  return code;
}

int nsdae_moment_arm_check_doubt(nsdae_moment_arms *arms, double *H, int *turns, double tol,
                                 char *text, size_t size)
{
  const nsdae_dims *d = &arms->all.system->dims;
  int code = 0;
  turner t;
  *text = '\0';
  memset(turns, 0, (size_t)d->nv * sizeof *turns);
  for (int j = 0; j + 2 < d->nv && d->nq > d->nv && code == 0; j++)
    turns[j] = read_turner(arms, j, H, &t, &code);
  for (int j = 0; j + 2 < d->nv && code == 0 && !*text; j++)
    if (turns[j] && read_turner(arms, j, H, &t, &code))
      code = doubt_body(arms, turns, &t, tol, text, size);
  return code;
}
