/* Vectors of three numbers and rotation matrices (column-major, columns are a frame's axes). */
#ifndef NSDAE_BODIES_SPACE_H
#define NSDAE_BODIES_SPACE_H

#include <math.h>

static const double nsdae_pi = 3.14159265358979323846;

static inline double nsdae_dot3(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* fmax, which is a call. */
static inline double nsdae_more_of(double a, double b)
{
  return a > b ? a : b;
}

static inline void nsdae_cross3(const double *a, const double *b, double *c)
{
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

/* The unit vector a along x; 0 if x has no direction. */
static inline int nsdae_unit_vector(const double *x, double *a)
{
  double length = sqrt(nsdae_dot3(x, x));
  for (int i = 0; i < 3; i++) a[i] = x[i] / length;
  return length > 0 && isfinite(length);
}

/* x := R s */
static inline void nsdae_turn(const double *R, const double *s, double *x)
{
  for (int i = 0; i < 3; i++) x[i] = R[i] * s[0] + R[3 + i] * s[1] + R[6 + i] * s[2];
}

/* s := R^T x */
static inline void nsdae_turn_back(const double *R, const double *x, double *s)
{
  for (int i = 0; i < 3; i++) s[i] = nsdae_dot3(R + 3 * i, x);
}

/* The rotation about z by an angle. */
static inline void nsdae_rotation_planar(double angle, double *R)
{
  double c = cos(angle), s = sin(angle);
  const double turned[9] = {c, s, 0, -s, c, 0, 0, 0, 1};
  for (int i = 0; i < 9; i++) R[i] = turned[i];
}

/* Brings a quaternion to unit length, all zero to (1, 0, 0, 0). 0 where it is not finite. */
static inline int nsdae_unit_quaternion(double *p)
{
  double most = 0, square = 0;
  for (int i = 0; i < 4; i++) {
    if (!isfinite(p[i])) return 0;
    most = fmax(most, fabs(p[i]));
  }
  if (most == 0) p[0] = most = 1;
  for (int i = 0; i < 4; i++) {
    p[i] /= most; /* no square overflows or vanishes */
    square += p[i] * p[i];
  }
  for (int i = 0; i < 4; i++) p[i] /= sqrt(square);
  return 1;
}

/* That of a quaternion of any length but zero: its length drifts, the rotation does not. */
static inline void nsdae_rotation_spatial(const double *p, double *R)
{
  double s = 2 / (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
  double w = p[0], x = p[1], y = p[2], z = p[3];
  const double turned[9] = {
      1 - s * (y * y + z * z), s * (x * y + w * z),     s * (x * z - w * y),
      s * (x * y - w * z),     1 - s * (x * x + z * z), s * (y * z + w * x),
      s * (x * z + w * y),     s * (y * z - w * x),     1 - s * (x * x + y * y)};
  for (int i = 0; i < 9; i++) R[i] = turned[i];
}

/* b and c such that a, b, c are at right angles, of unit length and right-handed; a is a unit
 * vector. */
static inline void nsdae_complete_frame(const double *a, double *b, double *c)
{
  int least = 0;
  for (int i = 1; i < 3; i++)
    if (fabs(a[i]) < fabs(a[least])) least = i;
  double e[3] = {0, 0, 0};
  e[least] = 1;
  nsdae_cross3(a, e, b);
  double length = sqrt(nsdae_dot3(b, b));
  for (int i = 0; i < 3; i++) b[i] /= length;
  nsdae_cross3(a, b, c);
}

/* The coordinate axis e such that a contact of normal n in space has e x n for its first tangent:
 * z, or x where n is near z. At the bound between them the frame turns over, and what a step begins
 * with is lost: so it lies far from normals of regular packings (that of two axes that n is along
 * as much does not), where rounding would turn it in every step. */
static inline int nsdae_tangent_axis(double n_z)
{
  return fabs(n_z) > 0.95 ? 0 : 2;
}

#endif
