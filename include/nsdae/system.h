/* nsdae: description of a non-smooth multibody system. BSD-3-Clause.
 *
 *   M(q) dv + Phi_q^T dLambda - W_N dLambda_N - W_T dLambda_T = F(t,q,v) dt
 *   Phi(t,q) = 0,   0 <= g_N(t,q)  _|_  Lambda_N >= 0,   |Lambda_T| <= mu Lambda_N
 *
 * The system has nq coordinates q, nv velocities v, m bilateral constraints and k contacts, each
 * with nt tangential directions. Units are the user's own and must be consistent (all examples use
 * SI).
 *
 * Arrays are column-major. Matrices are zero on entry and have a leading dimension; a callback
 * writes only their nonzero entries. A callback returns
 *
 * - 0: success
 * - > 0: failure that a smaller step may avoid
 * - < 0: fatal failure
 *
 * t, q and v belong to one point. A callback changes its outputs and the data of user only. A
 * system is constant while it has simulations. Several simulations, one per thread, may share a
 * system if the callbacks are thread-safe.
 *
 * All numbers start at 0: coordinates, constraints, contacts, frictional joints and entries, in
 * calls, error texts, tables and files. */
#ifndef NSDAE_SYSTEM_H
#define NSDAE_SYSTEM_H

#include <nsdae/contact.h>
#include <nsdae/shape.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A system; opaque. */
typedef struct nsdae_system nsdae_system;

/* Sizes of a system. */
typedef struct nsdae_dims {
  int nq; /* coordinates, >= 1 */
  int nv; /* velocities, 1 .. nq; 0: nq */
  int m;  /* bilateral constraints, >= 0 */
  int k;  /* contacts, >= 0 */
  int nt; /* tangential directions of every contact: 0 (frictionless), 1 (planar) or 2 */
  int f;  /* frictional joints: bilateral constraints with friction, 0 .. m */
} nsdae_dims;

/* callbacks.list: types */
/* M(t,q) [nv x nv], symmetric positive definite; both triangles. */
typedef int (*nsdae_mass_fn)(double t, const double *q, double *M, int ldm, void *user);
/* F(t,q,v) [nv]: all forces except those of constraints and contacts. */
typedef int (*nsdae_force_fn)(double t, const double *q, const double *v, double *F, void *user);
/* D(t,q,v) = -dF/dv [nv x nv], for the Newton matrix of implicit integrators. */
typedef int (*nsdae_force_damping_fn)(double t, const double *q, const double *v, double *D,
                                      int ldd, void *user);
/* K(t,q,v) = -(dF/dq) H [nv x nv] with dq/dt = H v, for the same matrix. */
typedef int (*nsdae_force_stiffness_fn)(double t, const double *q, const double *v, double *K,
                                        int ldk, void *user);
/* Phi(t,q) [m]. */
typedef int (*nsdae_constraint_fn)(double t, const double *q, double *phi, void *user);
/* Phi_q(t,q) [m x nv], such that d Phi / dt = Phi_q v + Phi_t. */
typedef int (*nsdae_constraint_jacobian_fn)(double t, const double *q, double *J, int ldj,
                                            void *user);
/* Phi_t(t,q) [m] and omega = (Phi_q v)_q v + 2 Phi_qt v + Phi_tt [m]. */
typedef int (*nsdae_constraint_bias_fn)(double t, const double *q, const double *v, double *phi_t,
                                        double *omega, void *user);
/* g_N(t,q) [k]: the distance of each contact, negative for an overlap. */
typedef int (*nsdae_gap_fn)(double t, const double *q, double *g, void *user);
/* W_N(t,q) [nv x k], such that d g_N / dt = W_N^T v + w_N. */
typedef int (*nsdae_gap_normal_fn)(double t, const double *q, double *W, int ldw, void *user);
/* W_T(t,q) [nv x k nt], such that v_T = W_T^T v + w_T; contact i has columns i nt .. i nt + nt-1,
 * for nt = 2 two perpendicular directions. */
typedef int (*nsdae_gap_tangent_fn)(double t, const double *q, double *W, int ldw, void *user);
/* w_N(t,q) [k] and w_T(t,q) [k nt]: velocities of the contacts at v = 0.
 * w_t is NULL if nt = 0. */
typedef int (*nsdae_contact_bias_fn)(double t, const double *q, double *w_n, double *w_t,
                                     void *user);
/* Accelerations at v' = 0 of contacts, omega_n [k] and omega_t [k nt], and of frictional
 * joints, omega_s [f]: g_N'' = W_N^T v' + omega_n, v_T' = W_T^T v' + omega_t,
 * v_S' = W_S^T v' + omega_s.
 * An empty array is NULL. */
typedef int (*nsdae_contact_acceleration_fn)(double t, const double *q, const double *v,
                                             double *omega_n, double *omega_t, double *omega_s,
                                             void *user);
/* W_S(t,q) [nv x f] and w_S(t,q) [f]: the slip velocity of each frictional joint is
 * v_S = W_S^T v + w_S. */
typedef int (*nsdae_frictional_joint_fn)(double t, const double *q, double *W, int ldw, double *w_s,
                                         void *user);
/* b(t,q,v) [f]: what varies of the bounds of the frictional joints, at least 0. It is added to
 * the constant ones of nsdae_system_set_friction_bound. A jump in time belongs at the end of a
 * step. */
typedef int (*nsdae_joint_friction_bound_fn)(double t, const double *q, const double *v,
                                             double *bound, void *user);
/* dq/dt [nq] from v [nv], linear in v. */
typedef int (*nsdae_kinematics_fn)(double t, const double *q, const double *v, double *qdot,
                                   void *user);
/* Potential energy U(t,q); used in energy reports only. */
typedef int (*nsdae_potential_fn)(double t, const double *q, double *energy, void *user);
/* Upper bound of |d g_N / dt| at (t,q,v) of every contact that a contact list can have. Methods
 * event and penalty derive from it the reach of a step. Without it they estimate the bound. */
typedef int (*nsdae_contact_speed_fn)(double t, const double *q, const double *v, double *speed,
                                      void *user);
/* callbacks.list: end */

/* Creates a system without callbacks. error may be NULL. NSDAE_E_ARGUMENT: a size is out of range;
 * NSDAE_E_MEMORY. */
NSDAE_API int nsdae_system_create(const nsdae_dims *dims, nsdae_system **system,
                                  nsdae_error *error);
/* Frees the system and sets *system to NULL; NULL and a pointer to NULL are allowed. Its
 * simulations remain valid: their data are freed with the last of them. */
NSDAE_API void nsdae_system_destroy(nsdae_system **system);

/* All setters below return NSDAE_OK, or < 0 and change nothing. NSDAE_E_ARGUMENT: invalid argument;
 * NSDAE_E_STATE: the system has simulations, which share it. The first error is stored:
 * nsdae_sim_create and nsdae_system_check return it until nsdae_system_clear_error. */

/* Clears the error record and the stored error of a setter. */
NSDAE_API void nsdae_system_clear_error(nsdae_system *system);

/* Number of existing simulations of the system; 0 if system is NULL. */
NSDAE_API int nsdae_system_simulations(const nsdae_system *system);

/* Sets the last argument of every callback; NULL by default. */
NSDAE_API int nsdae_system_set_user(nsdae_system *system, void *user);

/* Setters of the callbacks. Required are:
 *
 * - mass and force
 * - constraint if m > 0
 * - gap if k > 0
 * - gap_tangent if nt > 0 and any mu > 0
 * - frictional_joint_tangent (with blocks: or joint_friction_rows) if a frictional joint has mu > 0
 *  or a bound
 * - kinematics if nq != nv; else the default is the identity
 *
 * Other missing callbacks are replaced (nsdae_system_differences lists the first kind):
 *
 * - by central differences: constraint Jacobian and bias, gap normal, normal part of the contact
 *  bias; for method event also the contact acceleration
 * - by zero: tangential part of the contact bias
 * - by one-sided differences of F, only if an implicit integrator needs them: force_damping and
 *  force_stiffness. They change the number of Newton iterations, not the solution.
 *
 * NSDAE_E_ARGUMENT: system or callback is NULL, or the system has no such term. */
/* callbacks.list: declarations */
NSDAE_API int nsdae_system_set_mass(nsdae_system *system, nsdae_mass_fn callback);
NSDAE_API int nsdae_system_set_force(nsdae_system *system, nsdae_force_fn callback);
NSDAE_API int nsdae_system_set_force_damping(nsdae_system *system, nsdae_force_damping_fn callback);
NSDAE_API int nsdae_system_set_force_stiffness(nsdae_system *system,
                                               nsdae_force_stiffness_fn callback);
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
NSDAE_API int nsdae_system_set_joint_friction_bound(nsdae_system *system,
                                                    nsdae_joint_friction_bound_fn callback);
NSDAE_API int nsdae_system_set_kinematics(nsdae_system *system, nsdae_kinematics_fn callback);
NSDAE_API int nsdae_system_set_potential(nsdae_system *system, nsdae_potential_fn callback);
NSDAE_API int nsdae_system_set_contact_speed(nsdae_system *system, nsdae_contact_speed_fn callback);
/* callbacks.list: end */

/* Sets the coefficients of contact 0 <= i < k; the defaults are zero.
 *
 *   mu   friction, >= 0
 *   e_n  normal restitution (Newton), 0 .. 1
 *   e_t  tangential restitution, 0 .. 1
 *
 * NSDAE_E_ARGUMENT: mu > 0 and nt = 0. With gap_tangent, set the coefficients of every contact,
 * even if mu = 0: otherwise nsdae_sim_create returns NSDAE_E_STATE. */
NSDAE_API int nsdae_system_set_contact(nsdae_system *system, int i, double mu, double e_n,
                                       double e_t);

/* Sets frictional joint 0 <= j < f. Its friction F_S is at most b + mu |lambda|, against the slip
 * velocity v_S of the callback frictional_joint_tangent or joint_friction_rows:
 *
 *   F_S = -(b + mu |lambda|) sign(v_S) if v_S is not zero, |F_S| <= b + mu |lambda| if it is
 *
 * - nsdae_system_set_frictional_joint: a bilateral constraint with Coulomb friction, such as a
 *  slider in a slot without clearance. constraint is its number, 0 .. m-1. Phi of this constraint
 *  must be a length, so that its multiplier lambda is the normal force. mu >= 0.
 * - nsdae_system_set_friction_bound: b = bound >= 0 [N, or N m if v_S is a rate of angle], without
 *  a constraint: dry friction of a joint, a brake, a clutch. With w_S = -target it is a motor that
 *  holds this target speed with a force of at most b.
 * - nsdae_system_set_friction_circle: a pin of radius r with the coefficient of friction m adds
 *  radius |lambda| to b, radius = m r >= 0 [m]. lambda are the multipliers of 1 to 3 rows from the
 *  number constraint on: the force on the pin, if these Phi are lengths at right angles. It is
 *  found by substitution; if this does not converge, a step returns NSDAE_E_CONVERGENCE.
 *
 * A joint may have all; one with mu = 0 and no bound is frictionless. With one of the callbacks,
 * set every frictional joint: otherwise nsdae_sim_create returns NSDAE_E_STATE. */
NSDAE_API int nsdae_system_set_frictional_joint(nsdae_system *system, int j, int constraint,
                                                double mu);
NSDAE_API int nsdae_system_set_friction_bound(nsdae_system *system, int j, double bound);
NSDAE_API int nsdae_system_set_friction_circle(nsdae_system *system, int j, int constraint,
                                               int rows, double radius);

/* ---- large systems: v in blocks, block-sparse Jacobian, contact list
 *
 * q and v are divided into blocks, such as bodies. M is block diagonal. A row of Phi_q and a
 * direction of a contact involve few blocks. Contacts are fixed (dims.k), as in any system, or
 * those of a contact list: a callback lists the close contacts only. Islands that share no contact
 * and no constraint are then solved separately. All methods and options support both. */

/* Divides q and v into count blocks. Block b has nq[b] coordinates and nv[b] velocities, 1 <= nv[b]
 * <= nq[b], after those of block b - 1. The sums are dims.nq and dims.nv. The callback mass_blocks
 * replaces mass. The other callbacks have the complete vectors as in any system. kinematics must
 * compute dq/dt of a block from v of that block. */
NSDAE_API int nsdae_system_set_blocks(nsdae_system *system, int count, const int *nq,
                                      const int *nv);
/* Number of blocks: 1 by default, 0 if system is NULL. */
NSDAE_API int nsdae_system_get_blocks(const nsdae_system *system);

/* Diagonal blocks of M(t,q), nv[b] x nv[b] each, column-major, one after another; both triangles. M
 * is zero on entry. Required. */
typedef int (*nsdae_mass_blocks_fn)(double t, const double *q, double *M, void *user);
/* Sets the callback, with the errors of the setters above. */
NSDAE_API int nsdae_system_set_mass_blocks(nsdae_system *system, nsdae_mass_blocks_fn callback);

/* Rows of Phi_q that a callback fills; valid during the call. */
typedef struct nsdae_row_list nsdae_row_list;
/* Phi_q(t,q): calls nsdae_row_add for every block of every row. It replaces constraint_jacobian,
 * whose matrix is dense. */
typedef int (*nsdae_constraint_rows_fn)(double t, const double *q, nsdae_row_list *rows,
                                        void *user);
/* Sets the callback, with the errors of the setters above. NSDAE_E_ARGUMENT: also if m = 0. */
NSDAE_API int nsdae_system_set_constraint_rows(nsdae_system *system,
                                               nsdae_constraint_rows_fn callback);
/* W_S^T(t,q) by rows, and w_s(t,q) [f], which is zero on entry: calls nsdae_row_add for every block
 * of the row of every frictional joint. It replaces frictional_joint_tangent, whose matrix is
 * dense. */
typedef int (*nsdae_joint_friction_rows_fn)(double t, const double *q, nsdae_row_list *rows,
                                            double *w_s, void *user);
/* Sets the callback, with the errors of the setters above. NSDAE_E_ARGUMENT: also if f = 0. */
NSDAE_API int nsdae_system_set_joint_friction_rows(nsdae_system *system,
                                                   nsdae_joint_friction_rows_fn callback);
/* Adds the entries value [nv of the block] of a row in a block: 0 <= row < m of Phi_q, 0 <= row < f
 * of W_S^T. Rows must be in ascending order, each block once per row. Errors as nsdae_contact_add.
 */
NSDAE_API int nsdae_row_add(nsdae_row_list *rows, int row, int block, const double *value);

/* Blocks of D or K that a callback fills; valid during the call. */
typedef struct nsdae_block_list nsdae_block_list;
/* D = -dF/dv or K = -(dF/dq) H by blocks: calls nsdae_block_add for the blocks that are not zero.
 */
typedef int (*nsdae_force_blocks_fn)(double t, const double *q, const double *v,
                                     nsdae_block_list *blocks, void *user);
/* Set the callbacks for D and for K, with the errors of the setters above. They replace
 * force_damping and force_stiffness of a system without blocks. A missing one is replaced by
 * differences of F. These assume that a force on a block depends only on blocks that share a
 * constraint with it, or that the other callback coupled. */
NSDAE_API int nsdae_system_set_force_damping_blocks(nsdae_system *system,
                                                    nsdae_force_blocks_fn callback);
NSDAE_API int nsdae_system_set_force_stiffness_blocks(nsdae_system *system,
                                                      nsdae_force_blocks_fn callback);
/* Adds value [nv of row x nv of column], column-major, to the block (row, column), from 0. Blocks
 * may come in any order; those that come again are summed. NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE: as
 * nsdae_contact_add. */
NSDAE_API int nsdae_block_add(nsdae_block_list *blocks, int row, int column, const double *value);

/* Calls nsdae_contact_add for every contact with a gap of at most reach >= 0 at (t,q); additional
 * contacts are allowed. v is for swept volumes: gaps and directions must not depend on it. Without
 * this callback the system has no contacts. */
typedef int (*nsdae_contacts_fn)(double t, const double *q, const double *v, double reach,
                                 nsdae_contact_list *list, void *user);
/* Sets the callback, with the errors of the setters above. NSDAE_E_ARGUMENT: also if dims.k is not
 * 0. dims.nt applies to every contact. */
NSDAE_API int nsdae_system_set_contacts(nsdae_system *system, nsdae_contacts_fn callback);

/* Objects with a name; the comment is their number, from 0. */
enum nsdae_name_kind {
  NSDAE_NAME_COORDINATE,       /* nq */
  NSDAE_NAME_VELOCITY,         /* nv */
  NSDAE_NAME_CONSTRAINT,       /* m */
  NSDAE_NAME_CONTACT,          /* k */
  NSDAE_NAME_FRICTIONAL_JOINT, /* f */
  NSDAE_NAME_SENSOR            /* of nsdae_bodies_add_sensor, which names them */
};

/* Sizes of name and unit, including the terminating zero. */
enum { NSDAE_NAME_SIZE = 48, NSDAE_UNIT_SIZE = 24 };

/* Sets name and unit of object i of a kind, e.g. (NSDAE_NAME_COORDINATE, 2, "theta", "rad"). Both
 * are UTF-8 and copied. They appear in error texts, files, tables and plots. unit is that of the
 * coordinate, of Phi or of the gap; NULL or "": not given. Names of one kind must be unique;
 * nsdae_sim_create checks it. NSDAE_E_ARGUMENT: no such kind or number, name empty or NULL, text
 * too long or with control characters. */
NSDAE_API int nsdae_system_set_name(nsdae_system *system, int kind, int i, const char *name,
                                    const char *unit);
/* Sets the reference length of the error of object i of a kind. NSDAE_WARN_PENETRATION and
 * NSDAE_WARN_DRIFT use it (docs/methods/warnings.md):
 *
 * - NSDAE_NAME_CONTACT: width of the smaller body; contact list: width of block i
 * - NSDAE_NAME_CONSTRAINT: lever arm of the joint, or 1 if Phi is an angle
 *
 * 0 (default): unknown. Call it after nsdae_system_set_blocks. NSDAE_E_ARGUMENT: no such kind or
 * number; size is not finite or below 0. */
NSDAE_API int nsdae_system_set_size(nsdae_system *system, int kind, int i, double size);
/* Name and unit; "" if not set. The texts belong to the system. A velocity without a name has that
 * of its coordinate, and its unit per second, if there is no callback kinematics. */
NSDAE_API const char *nsdae_system_get_name(const nsdae_system *system, int kind, int i);
NSDAE_API const char *nsdae_system_get_unit(const nsdae_system *system, int kind, int i);
/* Number of values of sensor i (nsdae_bodies_add_sensor); 0: there is none. */
NSDAE_API int nsdae_system_sensor_size(const nsdae_system *system, int i);

/* Adds a body to the trajectory files of this system: its shape, and formulas of its pose. All data
 * are copied. nsdae_trajectory_create checks the formulas. nsdae_bodies_system adds every solid.
 * NSDAE_E_ARGUMENT (NULL, a number of points below 0), NSDAE_E_STATE, NSDAE_E_MEMORY. */
NSDAE_API int nsdae_system_add_body(nsdae_system *system, const nsdae_body *body);
/* These bodies and their number n; NULL if there are none. They belong to the system. */
NSDAE_API const nsdae_body *nsdae_system_get_bodies(const nsdae_system *system, int *n);

/* Error record of the last call on this system; if system is NULL, a record that says so. */
NSDAE_API const nsdae_error *nsdae_system_error(const nsdae_system *system);

/* Sizes of the system; nv is set if it was 0. */
NSDAE_API int nsdae_system_get_dims(const nsdae_system *system, nsdae_dims *dims);

/* Names of the terms that are computed by central differences, e.g. "constraint_bias gap_normal";
 * "" if none. The text belongs to the system. */
NSDAE_API const char *nsdae_system_differences(nsdae_system *system);

/* Largest error that nsdae_system_check found. */
typedef struct nsdae_check {
  char term[32];     /* name of the callback, e.g. "constraint_jacobian" */
  int row, column;   /* its entry, from 0 */
  double given;      /* value of the callback */
  double difference; /* value of central differences */
  double error;      /* |given - difference| / (1 + |difference|) of this entry */
} nsdae_check;

/* Checks every callback at (t, q [nq], v [nv]); q need not satisfy the constraints. worst may be
 * NULL. Checks in this order:
 *
 * - Each callback alone: writes outside its arrays, entries of Phi, g_N, dq/dt and U that are not
 *  written, NaN and infinity. Detected are writes up to the array's size (at most 8192) plus 64
 *  entries beyond either end.
 * - Every derivative against central differences, M against its transpose. tol = 1e-5 is a
 *  reasonable bound: differences have an error of about 1e-7 for values of order one.
 * - Tangential directions: zero, equal to the normal, or equal to each other.
 * - Tangential directions along the translations of one body: not of unit length, or not
 *  perpendicular to the normal and to each other.
 * - Tangential directions between two bodies in contact: not opposite.
 *
 * M and the gap identify the translations of one body. Velocities with different units are not
 * translations of one body, and a velocity in m/s (mm/s, ...) is no rotation.
 *
 * Systems with blocks: rows of Phi_q are checked entry by entry. Gaps of listed contacts are
 * checked by their rates along two trial velocities, and omega if it is given; row is the index in
 * the list, column the direction.
 *
 * nsdae_system_unseen reports what cannot be checked, and doubtful moment arms of W_T:
 *
 * - planar: a rotation about the arm would open the gap, or its sign differs from that of the
 *  body's other contacts
 * - spatial, body with a quaternion: the arm is not r x t of the point whose r x n is that of the
 *  gap, or a rotation about it would open the gap
 *
 * Status:
 *
 * - NSDAE_OK
 * - NSDAE_E_DERIVATIVE: the wrong entry is in worst and in the error record; a NaN in a derivative
 *  is wrong
 * - NSDAE_E_CALLBACK: a callback failed, or wrote outside its arrays (the text says which)
 * - NSDAE_E_NONFINITE, NSDAE_E_MEMORY
 * - NSDAE_E_STATE: a required callback is missing
 * - the stored error of a setter */
NSDAE_API int nsdae_system_check(nsdae_system *system, double t, const double *q, const double *v,
                                 double tol, nsdae_check *worst);

/* Properties of the given callbacks that no check can verify: "gap: its sign and unit; force: ...".
 * The text belongs to the system. */
NSDAE_API const char *nsdae_system_unseen(nsdae_system *system);

#ifdef __cplusplus
}
#endif
#endif
