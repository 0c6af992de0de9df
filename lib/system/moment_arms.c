#include "moment_arms.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "system_impl.h"

/* v^T H v of contact i along arms->v, at a fixed time: of a moving surface too. A
 * callback's code. */
static int moment_arms_bend(nsdae_moment_arms *arms, int i, double *bend)
{
  const nsdae_system *s = arms->all.system;
  int code = nsdae_differences_bend(arms->differences, s->call.gap, s->dims.k, arms->t, arms->q,
                                    arms->v, arms->bend);
  *bend = arms->bend[i];
  return code;
}

/* Whether differences of half the step give this bend too, to tol: where another edge or corner
 * comes to touch within a step, or bodies overlap by more than one, they are no derivative. */
static int moment_arms_bends(nsdae_moment_arms *arms, int i, double bend, double tol, int *bends)
{
  double finer = NAN;
  arms->differences->finer[1] = 1;
  int code = moment_arms_bend(arms, i, &finer);
  arms->differences->finer[1] = 0;
  *bends = fabs(finer - bend) <= tol;
  return code;
}

/* n x t, of two translations. */
static double turns(const nsdae_contact_directions *c, int of, double tol)
{
  int second = of + 1;
  while (second < c->nv && !nsdae_tangent_translates(c, of, second, tol)) second++;
  if (second == c->nv) return 0;
  return c->normal[of] * c->tangent[second] - c->normal[second] * c->tangent[of];
}

/* Rates along arms->v: of b, and how fast n turns towards t. */
typedef struct turning {
  double arm, normal;
} turning;

/* Adds those of one side, of displacement and weight +-s. */
static int add_side(nsdae_moment_arms *arms, const nsdae_contact_directions *c, int i, int of,
                    int j, double s, double tol, turning *sum)
{
  nsdae_differences *d = arms->differences;
  const nsdae_system *system = c->system;
  int n = c->nv;
  double *along = arms->bend + system->dims.k;
  for (int l = 0; l < system->dims.nq; l++) d->moved[l] = arms->q[l] + s * arms->rate[l];
  memset(d->W, 0, (size_t)n * (size_t)system->dims.k * sizeof *d->W);
  int code = system->call.gap_tangent(arms->t, d->moved, d->W, n, system->user);
  if (code) d->failed = "gap_tangent";
  sum->arm += d->W[(size_t)i * (size_t)n + (size_t)j] / (2 * s);
  if (code) return code;
  /* t . n at d->moved, t the translations of the direction here: the rate of gap i along them */
  for (int l = 0; l < n; l++)
    along[l] = nsdae_tangent_translates(c, of, l, tol) ? c->tangent[l] : 0;
  code = nsdae_differences_along(d, system->call.gap, system->dims.k, arms->t, d->moved, along,
                                 arms->bend);
  sum->normal += arms->bend[i] / (2 * s);
  return code;
}

/* What the contacts of one body and one of its rotations said so far. */
typedef struct sense {
  double sign;
  int contact;
} sense;

/* What a contact says of one rotation: an arm b, what it is about. */
typedef struct arm {
  int contact, velocity;
  double a, b, turns, bend; /* n x t; v^T H v */
  turning rate;
} arm;

/* What differences may be off. */
static double small_of(const arm *x, double tol)
{
  return 100 * tol * (1 + fabs(x->bend));
}

static void judge(const nsdae_system *s, const arm *x, double tol, sense *seen, char *text,
                  size_t size)
{
  char contact[NSDAE_CALLED_SIZE], velocity[NSDAE_CALLED_SIZE], other[NSDAE_CALLED_SIZE];
  double small = small_of(x, tol), sign = 0;
  /* s of (1), where a is long enough to tell; it should be -1 or 1 */
  double found = (x->rate.arm + x->rate.normal * x->a) / (x->turns * x->a);
  int tells = fabs(x->a) > 0.05 * (fabs(x->b) + fabs(x->bend)) && isfinite(found);
  /* neither gap nor directions change along the turn, and it is no disc's: it moves the body and
   * turns nothing */
  int moves_along = fabs(x->a) > small && fabs(x->bend) <= small && fabs(x->rate.arm) <= small &&
                    fabs(x->rate.normal) <= small;
  if (!isfinite(x->bend) || moves_along) return;
  nsdae_system_called(s, NSDAE_NAME_CONTACT, x->contact, contact);
  nsdae_system_called(s, NSDAE_NAME_VELOCITY, x->velocity, velocity);
  if (x->bend > fabs(x->b) + small) {
    snprintf(text, size,
             "gap_tangent: its arm %.4g of %s along %s, if this rotates the body: it should be at "
             "least %.4g, otherwise a rotation about the contact opens the gap",
             x->b + 0.0, contact, velocity, x->bend); /* no -0 */
  } else if (tells) {
    double normal = x->rate.normal;
    if (fabs(fabs(found) - 1) > 0.01)
      snprintf(
          text, size,
          "gap_tangent: its arm %.4g of %s along %s, if this rotates the body: a rotation about "
          "the contact changes it at the rate %.4g, and the arm of a point at %.4g or %.4g",
          x->b + 0.0, contact, velocity, x->rate.arm + 0.0, (x->turns - normal) * x->a + 0.0,
          (-x->turns - normal) * x->a + 0.0);
    sign = -found;
  } else if (x->bend > -fabs(x->b) * (1 - 1e-3) && fabs(x->b) > tol) {
    sign = x->turns * x->b;
  }
  if (*text || sign == 0) return;
  if (seen->sign * sign < 0)
    snprintf(text, size, "gap_tangent: the sign of its arm of %s along %s, which differs at %s",
             contact, velocity, nsdae_system_called(s, NSDAE_NAME_CONTACT, seen->contact, other));
  if (seen->sign == 0) *seen = (sense){sign, x->contact};
}

static int doubt_one(nsdae_moment_arms *arms, int i, int of, int j, double tol, sense *seen,
                     char *text, size_t size)
{
  const nsdae_contact_directions c = nsdae_tangent_contact(&arms->all, i);
  const sense before = *seen;
  arm x = {i, j, .a = c.normal[j], .b = c.tangent[j], .turns = turns(&c, of, tol)};
  int bends = 1;
  /* v = e_j - a n - b t, of the translations of velocity `of` */
  for (int l = 0; l < c.nv; l++)
    arms->v[l] =
        nsdae_tangent_translates(&c, of, l, tol) ? -x.a * c.normal[l] - x.b * c.tangent[l] : 0;
  arms->v[j] = 1;
  int code = moment_arms_bend(arms, i, &x.bend);
  if (code) return code;
  code = nsdae_kinematics(c.system, arms->t, arms->q, arms->v, arms->rate);
  if (code) arms->differences->failed = "kinematics";
  double s = nsdae_differences_step(c.system->dims.nq, arms->t, arms->q, arms->rate, 1e-5);
  if (!code) code = add_side(arms, &c, i, of, j, s, tol, &x.rate);
  if (!code) code = add_side(arms, &c, i, of, j, -s, tol, &x.rate);
  if (!code) judge(c.system, &x, tol, seen, text, size);
  if (!code && *text) code = moment_arms_bends(arms, i, x.bend, small_of(&x, tol), &bends);
  if (bends) return code;
  *text = '\0';
  *seen = before;
  return code;
}

/* Whether contact i has to do with velocity j, which moves alone, beside the body that `of` moves,
 * which slides there. */
static int concerns(const nsdae_contact_directions *c, int i, int of, int j, double tol)
{
  if (!(c->system->contact[i].mu > 0) || c->set[j] == NSDAE_TANGENT_COUPLED) return 0;
  /* not what has a length per second as its unit */
  const char *unit = nsdae_system_get_unit(c->system, NSDAE_NAME_VELOCITY, j);
  size_t length = strlen(unit);
  if (length >= 3 && strcmp(unit + length - 3, "m/s") == 0) return 0;
  if (c->normal[j] == 0 && c->other[j] == 0 && c->tangent[j] == 0) return 0;
  if (!nsdae_tangent_translates(c, of, of, tol) || nsdae_tangent_translates(c, of, j, tol))
    return 0;
  return turns(c, of, tol) != 0;
}

/* The first doubt as text of that size, "" where there is none; a callback's code. */
static int doubt_planar(nsdae_moment_arms *arms, double tol, char *text, size_t size)
{
  const nsdae_system *s = arms->all.system;
  int n = arms->all.nv, code = 0;
  *text = '\0';
  for (int of = 0; of < n; of++)
    for (int j = 0; j < n && arms->all.set[of] == of; j++) {
      sense seen = {0};
      for (int i = 0; i < s->dims.k && code == 0 && !*text; i++) {
        const nsdae_contact_directions c = nsdae_tangent_contact(&arms->all, i);
        if (!concerns(&c, i, of, j, tol)) continue;
        code = doubt_one(arms, i, of, j, tol, &seen, text, size);
      }
    }
  return code;
}

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

/* Brings the quaternions in q, which is arms->q, to length one: for others R(e) need be no
 * rotation. */
static int normalise(const nsdae_moment_arms *arms, double *H, double *q)
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
  int code = moment_arms_bend(arms, l->contact, &bend);
  *any = bend + nsdae_dot(3, r, l->along[0]) > small;
  return code || !*any ? code : moment_arms_bends(arms, l->contact, bend, small, any);
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

/* As doubt_planar, where nt = 2; H [3 nq] and turns [nv] are work. */
static int doubt_spatial(nsdae_moment_arms *arms, double *H, int *turns, double tol, char *text,
                         size_t size)
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

/* ---- contact directions */

void nsdae_directions_layout(nsdae_directions *d, nsdae_arena *arena)
{
  const nsdae_dims *dims = &d->differences->system->dims;
  long n = dims->nv, k = dims->k;
  const nsdae_blocks *blocks = &d->differences->system->blocks;
  d->M = NSDAE_ARENA_DOUBLES(arena, blocks->square[blocks->count]);
  nsdae_arena_doubles(arena, n * k, (double **[]){&d->normal, &d->other, NULL});
  d->tangent = NSDAE_ARENA_DOUBLES(arena, n * k * dims->nt);
  nsdae_arena_doubles(arena, n, (double **[]){&d->mass, &d->arms.v, NULL});
  nsdae_arena_doubles(arena, dims->nq, (double **[]){&d->place, &d->q, &d->arms.rate, NULL});
  d->turn = NSDAE_ARENA_DOUBLES(arena, 3L * dims->nq);
  nsdae_arena_ints(arena, dims->nv, (int **[]){&d->turns, &d->set, NULL});
  d->arms.bend = NSDAE_ARENA_DOUBLES(arena, k + n);
}

/* Of a code that is not 0, the callback. */
static int failed(const nsdae_directions *d, int code, const char *callback)
{
  if (code) d->differences->failed = callback;
  return code;
}

static int mass_at(nsdae_directions *d, double t, const double *q)
{
  const nsdae_system *s = d->differences->system;
  memset(d->M, 0, s->blocks.square[s->blocks.count] * sizeof *d->M);
  if (s->by_blocks) return failed(d, s->call.mass_blocks(t, q, d->M, s->user), "mass_blocks");
  return failed(d, s->call.mass(t, q, d->M, s->dims.nv, s->user), "mass");
}

static int normals_at(nsdae_directions *d, double t, const double *q, double *W)
{
  const nsdae_system *s = d->differences->system;
  int n = s->dims.nv, k = s->dims.k;
  memset(W, 0, (size_t)n * (size_t)k * sizeof *W);
  if (s->call.gap_normal) return failed(d, s->call.gap_normal(t, q, W, n, s->user), "gap_normal");
  return nsdae_differences_velocity(d->differences, s->call.gap, k, t, q, W, n, 1);
}

/* M_ii of a velocity that M does not couple with others, else 0; of velocity i of a block. */
static double free_mass(int n, const double *M, int i)
{
  for (int j = 0; j < n; j++)
    if (j != i && (M[i * n + j] != 0 || M[j * n + i] != 0)) return 0;
  return M[i * (n + 1)];
}

/* A body's mass is what it is everywhere, and so is the inertia of one that turns in the plane.
 * first: the diagonal of M elsewhere; then what of it is the same here. */
static void find_masses(nsdae_directions *d, int first)
{
  const nsdae_blocks *blocks = &d->differences->system->blocks;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b);
    const double *M = d->M + blocks->square[b];
    for (int i = 0; i < n; i++) {
      double *mass = &d->mass[blocks->first[b] + i],
             here = first ? M[i * (n + 1)] : free_mass(n, M, i);
      *mass = first || fabs(here - *mass) <= 1e-9 * fabs(here) ? here : 0;
    }
  }
}

int nsdae_directions_at(nsdae_directions *d, double t, const double *q)
{
  const nsdae_system *s = d->differences->system;
  int n = s->dims.nv, columns = s->dims.k * s->dims.nt;
  d->arms = (nsdae_moment_arms){{s, n, s->dims.nt, d->set, d->normal, d->other, d->tangent},
                                d->differences,
                                t,
                                d->q,
                                d->arms.v,
                                d->arms.rate,
                                d->arms.bend};
  memcpy(d->q, q, (size_t)s->dims.nq * sizeof *q);
  int code = failed(d, s->dims.nt == 2 ? normalise(&d->arms, d->turn, d->q) : 0, "kinematics");
  /* place [nq]: a little from q along a motion. */
  if (!code) {
    for (int i = 0; i < s->dims.nv; i++) d->arms.v[i] = 0.1 / (2 + i);
    code = nsdae_kinematics(s, t, d->q, d->arms.v, d->place);
    for (int i = 0; i < s->dims.nq; i++) d->place[i] += d->q[i];
    code = failed(d, code, "kinematics");
  }
  if (!code) code = normals_at(d, t, d->q, d->normal);
  if (!code) code = normals_at(d, t, d->place, d->other);
  if (!code) code = mass_at(d, t, d->place);
  if (!code) find_masses(d, 1);
  if (!code) code = mass_at(d, t, d->q);
  if (code) return code;
  find_masses(d, 0);
  nsdae_tangent_sets(s, d->mass, d->set);
  memset(d->tangent, 0, (size_t)n * (size_t)columns * sizeof *d->tangent);
  return failed(d, s->call.gap_tangent(t, d->q, d->tangent, n, s->user), "gap_tangent");
}

int nsdae_directions_wrong(const nsdae_directions *d, double tol, char why[NSDAE_TANGENT_TEXT])
{
  const nsdae_dims *dims = &d->differences->system->dims;
  for (int j = 0; j < dims->k * dims->nt; j++) {
    const nsdae_contact_directions c = nsdae_tangent_contact(&d->arms.all, j / dims->nt);
    if (d->differences->system->contact[j / dims->nt].mu > 0 &&
        nsdae_tangent_wrong(&c, j % dims->nt, tol, why))
      return j;
  }
  return -1;
}

/* Whether gap i is a length: impulses along a scaled one are scaled the other way. */
static void doubt_gap(const nsdae_directions *d, int i, double tol, char *text, size_t size)
{
  char why[NSDAE_TANGENT_TEXT], called[NSDAE_CALLED_SIZE];
  const nsdae_contact_directions c = nsdae_tangent_contact(&d->arms.all, i);
  if (c.system->contact[i].mu > 0 && nsdae_gap_scaled(&c, tol, why))
    snprintf(text, size, "gap: that of %s %s",
             nsdae_system_called(c.system, NSDAE_NAME_CONTACT, i, called), why);
}

int nsdae_directions_doubt(nsdae_directions *d, double tol, char *text, size_t size)
{
  const nsdae_dims *dims = &d->differences->system->dims;
  int code = dims->nt == 1 ? doubt_planar(&d->arms, tol, text, size)
                           : doubt_spatial(&d->arms, d->turn, d->turns, tol, text, size);
  for (int i = 0; i < dims->k && code == 0 && !*text; i++) doubt_gap(d, i, tol, text, size);
  return code;
}
