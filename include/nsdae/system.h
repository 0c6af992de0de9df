/* nsdae: the description of a non-smooth multibody system. BSD-3-Clause.
 *
 *   M(q) dv + Phi_q^T dLambda - W_N dLambda_N - W_T dLambda_T = F(t,q,v) dt
 *   Phi(t,q) = 0,   0 <= g_N(t,q)  _|_  Lambda_N >= 0,   |Lambda_T| <= mu Lambda_N
 *
 * with nq coordinates q, nv velocities v, m bilateral constraints and k contacts of nt tangential
 * directions each. Every array is column-major; matrices come zeroed and with their leading
 * dimension, so that a callback writes only what is not zero. Units are the user's own, used
 * consistently (SI in all examples).
 *
 * Callbacks return 0 when done, > 0 for a failure that a smaller step may avoid, < 0 for one that
 * nothing helps. They see t, q and v of one point and must not change anything but their outputs
 * and what user points to. A system is constant while it has simulations: one system may serve
 * many, one per thread, if the callbacks allow it.
 *
 * Everything is numbered from 0: coordinates, constraints, contacts, frictional joints and entries,
 * here, in error texts, tables and files. */
#ifndef NSDAE_SYSTEM_H
#define NSDAE_SYSTEM_H

#include <nsdae/contact.h>
#include <nsdae/shape.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A description; opaque. */
typedef struct nsdae_system nsdae_system;

/* Its sizes. */
typedef struct nsdae_dims {
  int nq; /* coordinates, >= 1 */
  int nv; /* velocities, 1 .. nq; 0 means nq */
  int m;  /* bilateral constraints, >= 0 */
  int k;  /* contacts, >= 0 */
  int nt; /* tangential directions of every contact: 0 (frictionless), 1 (planar) or 2 */
  int f;  /* frictional joints: bilateral constraints with friction, 0 .. m */
} nsdae_dims;

/* callbacks.list: types */
/* M(t,q) [nv x nv], symmetric positive definite; both triangles. */
typedef int (*nsdae_mass_fn)(double t, const double *q, double *M, int ldm, void *user);
/* F(t,q,v) [nv]: all forces but those of constraints and contacts. */
typedef int (*nsdae_force_fn)(double t, const double *q, const double *v, double *F, void *user);
/* Phi(t,q) [m]. */
typedef int (*nsdae_constraint_fn)(double t, const double *q, double *phi, void *user);
/* Phi_q(t,q) [m x nv], such that d Phi / dt = Phi_q v + Phi_t. */
typedef int (*nsdae_constraint_jacobian_fn)(double t, const double *q, double *J, int ldj,
                                            void *user);
/* Phi_t(t,q) [m] and omega = (Phi_q v)_q v + 2 Phi_qt v + Phi_tt [m]. */
typedef int (*nsdae_constraint_bias_fn)(double t, const double *q, const double *v, double *phi_t,
                                        double *omega, void *user);
/* g_N(t,q) [k]: the distance of each contact, negative where its bodies overlap. */
typedef int (*nsdae_gap_fn)(double t, const double *q, double *g, void *user);
/* W_N(t,q) [nv x k], such that d g_N / dt = W_N^T v + w_N. */
typedef int (*nsdae_gap_normal_fn)(double t, const double *q, double *W, int ldw, void *user);
/* W_T(t,q) [nv x k nt], such that v_T = W_T^T v + w_T; contact i has columns i nt .. i nt + nt-1,
 * for nt = 2 two directions at right angles. */
typedef int (*nsdae_gap_tangent_fn)(double t, const double *q, double *W, int ldw, void *user);
/* w_N(t,q) [k] and w_T(t,q) [k nt]: the velocities that the contacts have with v = 0.
 * w_t is NULL where nt = 0. */
typedef int (*nsdae_contact_bias_fn)(double t, const double *q, double *w_n, double *w_t,
                                     void *user);
/* Accelerations at v' = 0 of contacts, omega_n [k] and omega_t [k nt], and of frictional
 * joints, omega_s [f]: g_N'' = W_N^T v' + omega_n, v_T' = W_T^T v' + omega_t,
 * v_S' = W_S^T v' + omega_s.
 * An array is NULL where it would be empty. */
typedef int (*nsdae_contact_acceleration_fn)(double t, const double *q, const double *v,
                                             double *omega_n, double *omega_t, double *omega_s,
                                             void *user);
/* W_S(t,q) [nv x f] and w_S(t,q) [f]: the slip velocity of each frictional joint is
 * v_S = W_S^T v + w_S. */
typedef int (*nsdae_frictional_joint_fn)(double t, const double *q, double *W, int ldw, double *w_s,
                                         void *user);
/* dq/dt [nq] from v [nv], linear in v. */
typedef int (*nsdae_kinematics_fn)(double t, const double *q, const double *v, double *qdot,
                                   void *user);
/* Potential energy U(t,q); used only to report energies. */
typedef int (*nsdae_potential_fn)(double t, const double *q, double *energy, void *user);
/* callbacks.list: end */

/* Makes a description without callbacks. error may be NULL.
 * NSDAE_E_ARGUMENT (a size outside its range), NSDAE_E_MEMORY. */
NSDAE_API int nsdae_system_create(const nsdae_dims *dims, nsdae_system **system,
                                  nsdae_error *error);
/* Releases it and sets *system to NULL; NULL and a pointer to NULL are allowed. Its simulations
 * go on: what they need of it is released with the last of them. */
NSDAE_API void nsdae_system_destroy(nsdae_system **system);

/* All setters below return NSDAE_OK, or < 0 and change nothing: NSDAE_E_ARGUMENT, and NSDAE_E_STATE
 * while the system has simulations, for they share it. A refusal cannot be overlooked: the first
 * one is what nsdae_sim_create and nsdae_system_check return, until nsdae_system_clear_error. */

/* Takes note of what was refused: clears the error record and what is remembered. */
NSDAE_API void nsdae_system_clear_error(nsdae_system *system);

/* How many simulations it has now; 0 of NULL. */
NSDAE_API int nsdae_system_simulations(const nsdae_system *system);

/* Handed to every callback as its last argument; NULL at first. */
NSDAE_API int nsdae_system_set_user(nsdae_system *system, void *user);

/* mass and force are always needed, constraint where m > 0, gap where k > 0, gap_tangent where
 * nt > 0 and any mu > 0, frictional_joint_tangent where a frictional joint has mu > 0. What else is
 * missing is filled by central differences (constraint Jacobian and bias, gap normal and the normal
 * part of the contact bias; for the method event the contact acceleration; nsdae_system_differences
 * says which) or taken as zero (tangential bias); kinematics is the identity where nq = nv.
 * NSDAE_E_ARGUMENT: system or callback NULL, or the system has no such term. */
/* callbacks.list: declarations */
NSDAE_API int nsdae_system_set_mass(nsdae_system *system, nsdae_mass_fn callback);
NSDAE_API int nsdae_system_set_force(nsdae_system *system, nsdae_force_fn callback);
NSDAE_API int nsdae_system_set_constraint(nsdae_system *system, nsdae_constraint_fn callback);
NSDAE_API int nsdae_system_set_constraint_jacobian(nsdae_system *system,
                                                   nsdae_constraint_jacobian_fn callback);
NSDAE_API int nsdae_system_set_constraint_bias(nsdae_system *system,
                                               nsdae_constraint_bias_fn callback);
NSDAE_API int nsdae_system_set_gap(nsdae_system *system, nsdae_gap_fn callback);
NSDAE_API int nsdae_system_set_gap_normal(nsdae_system *system, nsdae_gap_normal_fn callback);
NSDAE_API int nsdae_system_set_gap_tangent(nsdae_system *system, nsdae_gap_tangent_fn callback);
NSDAE_API int nsdae_system_set_contact_bias(nsdae_system *system, nsdae_contact_bias_fn callback);
NSDAE_API int nsdae_system_set_contact_acceleration(nsdae_system *system,
                                                    nsdae_contact_acceleration_fn callback);
NSDAE_API int nsdae_system_set_frictional_joint_tangent(nsdae_system *system,
                                                        nsdae_frictional_joint_fn callback);
NSDAE_API int nsdae_system_set_kinematics(nsdae_system *system, nsdae_kinematics_fn callback);
NSDAE_API int nsdae_system_set_potential(nsdae_system *system, nsdae_potential_fn callback);
/* callbacks.list: end */

/* Coefficients of contact 0 <= i < k; all zero at first.
 *   mu   friction, >= 0           e_n  normal restitution (Newton), 0 .. 1
 *   e_t  tangential restitution, 0 .. 1
 * mu > 0 needs tangential directions: NSDAE_E_ARGUMENT where nt = 0. Where gap_tangent gives
 * directions every contact must be told of, if only with mu = 0: else nsdae_sim_create returns
 * NSDAE_E_STATE. */
NSDAE_API int nsdae_system_set_contact(nsdae_system *system, int i, double mu, double e_n,
                                       double e_t);

/* Slide 0 <= j < f: a bilateral constraint with Coulomb friction, such as a slider in a slot
 * without play: friction of at most mu |lambda| along the direction of the callback
 * frictional_joint_tangent. The constraint (its number, 0 .. m-1) must be scaled as a length, so
 * that its multiplier lambda is the normal force. mu >= 0; with mu = 0 it has no friction. Where
 * frictional_joint_tangent is given every slide must be told of: else nsdae_sim_create returns
 * NSDAE_E_STATE. */
NSDAE_API int nsdae_system_set_frictional_joint(nsdae_system *system, int j, int constraint,
                                                double mu);

/* ---- large systems: v in blocks, contacts by list
 *
 * q and v are split into blocks, such as bodies. M is block diagonal, a row of Phi_q and a
 * direction of a contact touch few blocks, and only contacts that are near are spoken of, in a
 * list. A step then costs what is there: parts that no closed contact and no constraint joins are
 * solved one by one. The methods are implicit, implicit-printed and moreau; penalty and event, the
 * option projection and nsdae_sim_project refuse such a system. */

/* Block b has nq[b] coordinates and nv[b] velocities, 1 <= nv[b] <= nq[b], behind those of block
 * b - 1; the sums are dims.nq and dims.nv. Such a system has dims.k = dims.f = 0; dims.nt is that
 * of every contact. In place of the callbacks mass, constraint_jacobian and those of numbered
 * contacts it takes the three below; all others are of the whole vectors as in any system, and the
 * kinematics must take dq/dt of a block from v of that block. */
NSDAE_API int nsdae_system_set_blocks(nsdae_system *system, int count, const int *nq,
                                      const int *nv);
/* How many there are: 1 where none were set, 0 of NULL. */
NSDAE_API int nsdae_system_get_blocks(const nsdae_system *system);

/* The diagonal blocks of M(t,q), nv[b] x nv[b] each, column-major, one after another; both
 * triangles. M comes zeroed. Always needed. */
typedef int (*nsdae_mass_blocks_fn)(double t, const double *q, double *M, void *user);
/* Setters as those above: NSDAE_OK, NSDAE_E_ARGUMENT, NSDAE_E_STATE. */
NSDAE_API int nsdae_system_set_mass_blocks(nsdae_system *system, nsdae_mass_blocks_fn callback);

/* The rows of Phi_q that a callback fills; they live as long as the call. */
typedef struct nsdae_row_list nsdae_row_list;
/* Phi_q(t,q): nsdae_row_add for every block that a row touches. Needed where m > 0. */
typedef int (*nsdae_constraint_rows_fn)(double t, const double *q, nsdae_row_list *rows,
                                        void *user);
/* The same. NSDAE_E_ARGUMENT also where the system has no constraints. */
NSDAE_API int nsdae_system_set_constraint_rows(nsdae_system *system,
                                               nsdae_constraint_rows_fn callback);
/* value [nv of the block]: the entries of row 0 <= row < m over that block. Rows come in ascending
 * order, each block once. Returns as nsdae_contact_add does. */
NSDAE_API int nsdae_row_add(nsdae_row_list *rows, int row, int block, const double *value);

/* nsdae_contact_add for every contact with a gap of at most reach >= 0 at (t,q); more do no harm.
 * v is that of the point, for what is swept: gaps and directions must not depend on it. Without
 * this callback there are no contacts. */
typedef int (*nsdae_contacts_fn)(double t, const double *q, const double *v, double reach,
                                 nsdae_contact_list *list, void *user);
/* The same. */
NSDAE_API int nsdae_system_set_contacts(nsdae_system *system, nsdae_contacts_fn callback);

/* What can have a name: each has as many as the system's sizes say, numbered from 0. */
enum nsdae_name_kind {
  NSDAE_NAME_COORDINATE,      /* nq */
  NSDAE_NAME_VELOCITY,        /* nv */
  NSDAE_NAME_CONSTRAINT,      /* m */
  NSDAE_NAME_CONTACT,         /* k */
  NSDAE_NAME_FRICTIONAL_JOINT /* f */
};

/* Sizes of their texts, with the zero at the end. */
enum { NSDAE_NAME_SIZE = 48, NSDAE_UNIT_SIZE = 24 };

/* Name and unit of number i (from 0) of a kind, as in (NSDAE_NAME_COORDINATE, 2, "theta", "rad");
 * UTF-8, copied. They stand in error texts, files, tables and plots. The unit is that of the
 * coordinate, of the constraint's Phi or of the contact's gap; NULL or "": not said. Names of one
 * kind must differ, which is looked at when a simulation is made. NSDAE_E_ARGUMENT: no such kind or
 * number, a name that is empty or NULL, a text that is too long or has control characters. */
NSDAE_API int nsdae_system_set_name(nsdae_system *system, int kind, int i, const char *name,
                                    const char *unit);
/* A length that the error of number i of a kind is measured by: of a contact
 * (NSDAE_NAME_CONTACT), how wide the smaller of its bodies is; of contacts by list, how wide block
 * i is; of a constraint (NSDAE_NAME_CONSTRAINT), the arm of its joint, or 1 where Phi is an angle.
 * NSDAE_WARN_PENETRATION and NSDAE_WARN_DRIFT go by it: see docs/methods/warnings.md. 0: unknown,
 * as before. After nsdae_system_set_blocks. NSDAE_E_ARGUMENT: no such kind or number, size not
 * finite or below 0. */
NSDAE_API int nsdae_system_set_size(nsdae_system *system, int kind, int i, double size);
/* "" where there is none. A velocity without a name has that of its coordinate, and its unit is
 * that one's per second, where there is no callback kinematics. The texts live in the system. */
NSDAE_API const char *nsdae_system_get_name(const nsdae_system *system, int kind, int i);
NSDAE_API const char *nsdae_system_get_unit(const nsdae_system *system, int kind, int i);

/* Adds a body to what trajectory files of this system show: its shape, and formulas of where it is.
 * All is copied. What is wrong with it is said by nsdae_trajectory_create, which knows what
 * formulas may name. nsdae_bodies_system does it for every solid. NSDAE_E_ARGUMENT (NULL, a count
 * of points below 0), NSDAE_E_STATE, NSDAE_E_MEMORY. */
NSDAE_API int nsdae_system_add_body(nsdae_system *system, const nsdae_body *body);
/* Those bodies, n of them; NULL where there are none. They live in the system. */
NSDAE_API const nsdae_body *nsdae_system_get_bodies(const nsdae_system *system, int *n);

/* Why the last call on this system failed; of NULL a record that says so. */
NSDAE_API const nsdae_error *nsdae_system_error(const nsdae_system *system);

/* The sizes, with nv filled in. */
NSDAE_API int nsdae_system_get_dims(const nsdae_system *system, nsdae_dims *dims);

/* Names of the terms that are filled by differences, e.g. "constraint_bias gap_normal"; "" where
 * there is none. The text lives in the system. */
NSDAE_API const char *nsdae_system_differences(nsdae_system *system);

/* Worst disagreement that nsdae_system_check found. */
typedef struct nsdae_check {
  char term[32];     /* callback, e.g. "constraint_jacobian" */
  int row, column;   /* its entry, from 0 */
  double given;      /* what the callback says */
  double difference; /* what central differences say */
  double error;      /* |given - difference| / (1 + |difference|) of this entry */
} nsdae_check;

/* Looks at every callback that is given, at (t, q [nq], v [nv]); q need not satisfy the
 * constraints. First each alone: what it writes beyond its arrays (seen as far as the array's own
 * size, 8192 at most, and 64 entries more to either side), entries of Phi, g_N, dq/dt and U that it
 * never writes, and what is NaN or infinite. Then every derivative against central differences of
 * what it derives from, and the mass matrix against its transpose; then directions of friction that
 * are all zero, the normal's, or one twice, and, along the translations of a body that M and the
 * gap show to be free, not of length one or not at right angles to the normal and to each other,
 * or, on two bodies that touch each other, not opposite. Differences are good to about 1e-7 where
 * the values are of order one: tol of 1e-5 is a fair bound. Of a system of blocks the rows of Phi_q
 * are compared entry by entry, the gaps of contacts listed nearby by their rates along two trial
 * velocities (row is the place in the list). Velocities whose units are named and differ are not
 * taken for the translations of one body, and one in m/s (mm/s, ...) turns none. What cannot be
 * seen says nsdae_system_unseen, and what is doubtful: in the plane, an arm of W_T about which a
 * turn would open the gap, or whose sign is not that of the body's other contacts; in space, of a
 * body with a quaternion, arms that are not r x t of the point whose r x n the gap has, or about
 * which a turn would open the gap. NSDAE_OK; NSDAE_E_DERIVATIVE with the wrong entry in worst and
 * in the error record (a NaN in a derivative counts as wrong); NSDAE_E_CALLBACK (it failed, or the
 * text says what it writes); NSDAE_E_NONFINITE; NSDAE_E_STATE (a callback that is needed is
 * missing), NSDAE_E_MEMORY, and what a setter was refused with. worst may be NULL. */
NSDAE_API int nsdae_system_check(nsdae_system *system, double t, const double *q, const double *v,
                                 double tol, nsdae_check *worst);

/* What no check can see of the callbacks that are given: "gap: its sign and unit; force: ...". The
 * text lives in the system. */
NSDAE_API const char *nsdae_system_unseen(nsdae_system *system);

#ifdef __cplusplus
}
#endif
#endif
