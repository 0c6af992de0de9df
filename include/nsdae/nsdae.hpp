/* nsdae: C++ (11 and later). BSD-3-Clause.
 *
 * Owning handles for the C library. The C headers document what each member does. c() returns the
 * handle of C, for functions without a member.
 *
 * Errors: members throw nsdae::error if the C function returns < 0, and return its status >= 0.
 * Members named try_ do not throw; they return the status, and last_error() has the record. An
 * empty handle (default-constructed or moved from) fails with NSDAE_E_ARGUMENT.
 *
 * Callbacks are callable objects (lambdas, functions, function objects) with the arguments of the C
 * callback except user. They return void, or int with the codes of C. An exception of a callback
 * does not propagate through C code. The step fails, and the member that runs it rethrows the
 * exception. After a try_ member, take_exception() returns it.
 *
 * A simulation keeps its system alive, and a trajectory its simulation: handles may be destroyed in
 * any order. */
#ifndef NSDAE_HPP
#define NSDAE_HPP

#include <cstdio>
#include <exception>
#include <functional>
#include <limits>
#include <list>
#include <locale>
#include <memory>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <nsdae/nsdae.h>

namespace nsdae
{

/* A status < 0 with the error record of the C library. */
class error : public std::runtime_error
{
public:
  /* what() is the text of the record. */
  explicit error(const nsdae_error &record) : std::runtime_error(record.text), record_(record) {}
  /* enum nsdae_status, < 0. */
  int status() const noexcept { return record_.status; }
  /* The record: argument, where, index, time, text. */
  const nsdae_error &record() const noexcept { return record_; }

private:
  nsdae_error record_;
};

namespace detail
{

/* The exception of a callback of this thread until take_exception(). Exported, so that shared
 * objects that create and that run a callback share it. */
NSDAE_API inline std::exception_ptr &thrown() noexcept
{
  static thread_local std::exception_ptr slot;
  return slot;
}

inline nsdae_error make_record(int status, const char *argument, const std::string &text)
{
  nsdae_error record = nsdae_error();
  record.status = status;
  record.index = -1;
  record.time = std::numeric_limits<double>::quiet_NaN();
  std::snprintf(record.argument, sizeof record.argument, "%s", argument);
  std::snprintf(record.where, sizeof record.where, "%s", "nsdae.hpp");
  std::snprintf(record.text, sizeof record.text, "%s", text.c_str());
  return record;
}

/* For every call that may run callbacks or allocate: it returns a status and does not throw. */
template <class Call> int attempt(Call call) noexcept
{
  thrown() = nullptr;
  try {
    return call();
  } catch (const std::bad_alloc &) {
    return NSDAE_E_MEMORY;
  }
}

/* Returns a status >= 0, or throws error. */
inline int demand(int status, const nsdae_error *record)
{
  if (status >= 0) return status;
  if (record && record->status == status) throw error(*record);
  throw error(make_record(status, "", nsdae_status_message(status)));
}

/* A callable object as a function that returns a code. */
template <class... A> struct callback {
  std::function<int(A...)> call;

  callback() = default;
  template <class F> explicit callback(F f) { keep(f, std::is_void<result<F>>()); }

private:
  template <class F> using result = decltype(std::declval<F &>()(std::declval<A>()...));

  template <class F> void keep(F &f, std::true_type)
  {
    call = [f](A... a) mutable {
      f(a...);
      return 0;
    };
  }
  template <class F> void keep(F &f, std::false_type)
  {
    static_assert(std::is_same<result<F>, int>::value, "a callback returns void or int");
    call = std::move(f);
  }
};

/* Runs a callback for C: an exception is stored and becomes the given code. */
template <class Call> int shield(int code, Call call) noexcept
{
  try {
    return call();
  } catch (...) {
    thrown() = std::current_exception();
    return code;
  }
}

struct system_guts {
  nsdae_system *c = nullptr;
  callback<double, const double *, double *> mass_blocks;
  callback<double, const double *, nsdae_row_list *> constraint_rows;
  callback<double, const double *, nsdae_row_list *, double *> joint_friction_rows;
  callback<double, const double *, const double *, nsdae_block_list *> force_damping_blocks;
  callback<double, const double *, const double *, nsdae_block_list *> force_stiffness_blocks;
  callback<double, const double *, const double *, double, nsdae_contact_list *> contacts;
  /* callbacks.list: holders */
  /* clang-format off */
  callback<double, const double *, double *, int> mass;
  callback<double, const double *, const double *, double *> force;
  callback<double, const double *, const double *, double *, int> force_damping;
  callback<double, const double *, const double *, double *, int> force_stiffness;
  callback<double, const double *, double *> constraint;
  callback<double, const double *, double *, int> constraint_jacobian;
  callback<double, const double *, const double *, double *, double *> constraint_bias;
  callback<double, const double *, double *> gap;
  callback<double, const double *, double *, int> gap_normal;
  callback<double, const double *, double *, int> gap_tangent;
  callback<double, const double *, double *, double *> contact_bias;
  callback<double, const double *, const double *, double *, double *,
           double *> contact_acceleration;
  callback<double, const double *, double *, int, double *> frictional_joint_tangent;
  callback<double, const double *, const double *, double *> joint_friction_bound;
  callback<double, const double *, const double *, double *> kinematics;
  callback<double, const double *, double *> potential;
  callback<double, const double *, const double *, double *> contact_speed;
  /* clang-format on */
  /* callbacks.list: end */

  system_guts() = default;
  system_guts(const system_guts &) = delete;
  system_guts &operator=(const system_guts &) = delete;
  ~system_guts() { nsdae_system_destroy(&c); }
  std::shared_ptr<void> world; /* with the drives and loads that c calls; outlives c */
};

/* nsdae_bodies with the drives and forces that it calls. */
struct bodies_guts {
  typedef callback<double, double *> drive;
  typedef callback<double, const double *, const double *, double *, double *> load;
  nsdae_bodies *c = nullptr;
  std::list<drive> drives;
  std::list<load> loads;
  std::shared_ptr<system_guts> own; /* callbacks only */

  bodies_guts() = default;
  bodies_guts(const bodies_guts &) = delete;
  bodies_guts &operator=(const bodies_guts &) = delete;
  ~bodies_guts() { nsdae_bodies_destroy(&c); }

  static int run_drive(double t, double f[3], void *user) noexcept
  {
    return shield(-1, [&] { return static_cast<drive *>(user)->call(t, f); });
  }
  static int run_load(double t, const double x[3], const double v[3], double force[3],
                      double torque[3], void *user) noexcept
  {
    return shield(-1, [&] { return static_cast<load *>(user)->call(t, x, v, force, torque); });
  }
};

/* The C function for the member of system_guts that Member points to. */
template <class T, T Member> struct trampoline;
template <class... A, callback<A...> system_guts::*Member>
struct trampoline<callback<A...> system_guts::*, Member> {
  static int run(A... a, void *user) noexcept
  {
    return shield(-1, [&] { return (static_cast<system_guts *>(user)->*Member).call(a...); });
  }
};

struct sim_guts {
  typedef callback<const nsdae_record &> observer;

  nsdae_sim *c = nullptr;
  std::shared_ptr<system_guts> system;
  std::vector<std::unique_ptr<observer>> observers;
  std::unique_ptr<callback<>> interrupt;
  int status = NSDAE_OK; /* of the last run or step */

  sim_guts() = default;
  sim_guts(const sim_guts &) = delete;
  sim_guts &operator=(const sim_guts &) = delete;
  ~sim_guts() { nsdae_sim_destroy(&c); }

  static int observe(const nsdae_record *record, nsdae_error *, void *user) noexcept
  {
    return shield(NSDAE_E_CALLBACK, [&] { return static_cast<observer *>(user)->call(*record); });
  }
  static int ask(void *user) noexcept
  {
    return shield(1, [&] { return static_cast<callback<> *>(user)->call(); });
  }
};

} // namespace detail

/* Removes and returns the exception of a callback in the last failed try_ member of this thread;
 * null if there is none. */
inline std::exception_ptr take_exception() noexcept
{
  std::exception_ptr exception;
  std::swap(exception, detail::thrown());
  return exception;
}

namespace detail
{

/* demand() of a call that ran callbacks: an exception of a callback is rethrown instead. */
inline int demand_run(int status, const nsdae_error *record)
{
  if (status >= 0) return status;
  if (std::exception_ptr exception = take_exception()) std::rethrow_exception(exception);
  return demand(status, record);
}

/* data() of a vector of this size, or throws an error that names it. */
template <class V> const double *sized(const V &vector, int size, const char *name)
{
  if (static_cast<decltype(vector.size())>(size) == vector.size()) return vector.data();
  throw error(make_record(NSDAE_E_ARGUMENT, name,
                          std::string(name) + " has " + std::to_string(vector.size()) +
                              " entries: it must have " + std::to_string(size)));
}

} // namespace detail

/* nsdae_sim_options, with its defaults. */
class options
{
public:
  /* Every option at its default. */
  options() noexcept { nsdae_sim_options_default(&options_); }

  /* nsdae_sim_options_set: one option by its key and its value as text. */
  options &set(const std::string &key, const std::string &value)
  {
    nsdae_error record = nsdae_error();
    detail::demand(nsdae_sim_options_set(&options_, key.c_str(), value.c_str(), &record), &record);
    return *this;
  }
  /* Sets an option from a C string. */
  options &set(const std::string &key, const char *value) { return set(key, std::string(value)); }
  /* Sets an integer option, or a choice by its enum value. */
  options &set(const std::string &key, int value) { return set(key, std::to_string(value)); }
  /* Sets a real option exactly. */
  options &set(const std::string &key, double value)
  {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(17);
    text << value;
    return set(key, text.str());
  }

  /* Access to the fields: options->dt = 0.01. */
  nsdae_sim_options *operator->() noexcept { return &options_; }
  /* Read access to the fields. */
  const nsdae_sim_options *operator->() const noexcept { return &options_; }
  /* The struct for C functions. */
  const nsdae_sim_options *c() const noexcept { return &options_; }

private:
  nsdae_sim_options options_;
};

/* nsdae_system. Its user pointer is reserved: callbacks carry their own data. */
class system
{
public:
  /* An empty handle. */
  system() noexcept = default;
  /* A system of these sizes, without callbacks. */
  explicit system(const nsdae_dims &dims)
  {
    nsdae_error record = nsdae_error();
    detail::demand(try_create(dims, &record), &record);
  }
  /* The source becomes empty. */
  system(system &&) noexcept = default;
  /* The source becomes empty. */
  system &operator=(system &&) noexcept = default;

  /* Creates a new system; frees the old one. */
  int try_create(const nsdae_dims &dims, nsdae_error *record = nullptr) noexcept
  {
    guts_.reset();
    return detail::attempt([&] {
      std::shared_ptr<detail::system_guts> guts = std::make_shared<detail::system_guts>();
      int status = nsdae_system_create(&dims, &guts->c, record);
      if (status < 0) return status;
      nsdae_system_set_user(guts->c, guts.get());
      guts_ = guts;
      return status;
    });
  }

  /* Whether the handle is not empty. */
  explicit operator bool() const noexcept { return c() != nullptr; }
  /* The handle of C, or NULL. */
  nsdae_system *c() const noexcept { return guts_ ? guts_->c : nullptr; }

#define NSDAE_CALLBACK(name)                           \
  &detail::system_guts::name, nsdae_system_set_##name, \
      detail::trampoline<decltype(&detail::system_guts::name), &detail::system_guts::name>::run
  /* callbacks.list: members */
  /* M(t,q) [nv x nv], symmetric positive definite; both triangles.
   *   f(double t, const double *q, double *M, int ldm) */
  template <class F> system &mass(F f)
  {
    return keep(NSDAE_CALLBACK(mass), std::move(f));
  }
  /* F(t,q,v) [nv]: all forces except those of constraints and contacts.
   *   f(double t, const double *q, const double *v, double *F) */
  template <class F> system &force(F f)
  {
    return keep(NSDAE_CALLBACK(force), std::move(f));
  }
  /* D(t,q,v) = -dF/dv [nv x nv], for the Newton matrix of implicit integrators.
   *   f(double t, const double *q, const double *v, double *D, int ldd) */
  template <class F> system &force_damping(F f)
  {
    return keep(NSDAE_CALLBACK(force_damping), std::move(f));
  }
  /* K(t,q,v) = -(dF/dq) H [nv x nv] with dq/dt = H v, for the same matrix.
   *   f(double t, const double *q, const double *v, double *K, int ldk) */
  template <class F> system &force_stiffness(F f)
  {
    return keep(NSDAE_CALLBACK(force_stiffness), std::move(f));
  }
  /* Phi(t,q) [m].
   *   f(double t, const double *q, double *phi) */
  template <class F> system &constraint(F f)
  {
    return keep(NSDAE_CALLBACK(constraint), std::move(f));
  }
  /* Phi_q(t,q) [m x nv], such that d Phi / dt = Phi_q v + Phi_t.
   *   f(double t, const double *q, double *J, int ldj) */
  template <class F> system &constraint_jacobian(F f)
  {
    return keep(NSDAE_CALLBACK(constraint_jacobian), std::move(f));
  }
  /* Phi_t(t,q) [m] and omega = (Phi_q v)_q v + 2 Phi_qt v + Phi_tt [m].
   *   f(double t, const double *q, const double *v, double *phi_t, double *omega) */
  template <class F> system &constraint_bias(F f)
  {
    return keep(NSDAE_CALLBACK(constraint_bias), std::move(f));
  }
  /* g_N(t,q) [k]: the distance of each contact, negative for an overlap.
   *   f(double t, const double *q, double *g) */
  template <class F> system &gap(F f)
  {
    return keep(NSDAE_CALLBACK(gap), std::move(f));
  }
  /* W_N(t,q) [nv x k], such that d g_N / dt = W_N^T v + w_N.
   *   f(double t, const double *q, double *W, int ldw) */
  template <class F> system &gap_normal(F f)
  {
    return keep(NSDAE_CALLBACK(gap_normal), std::move(f));
  }
  /* W_T(t,q) [nv x k nt], such that v_T = W_T^T v + w_T; contact i has columns i nt .. i nt + nt-1,
   * for nt = 2 two perpendicular directions.
   *   f(double t, const double *q, double *W, int ldw) */
  template <class F> system &gap_tangent(F f)
  {
    return keep(NSDAE_CALLBACK(gap_tangent), std::move(f));
  }
  /* w_N(t,q) [k] and w_T(t,q) [k nt]: velocities of the contacts at v = 0.
   * w_t is NULL if nt = 0.
   *   f(double t, const double *q, double *w_n, double *w_t) */
  template <class F> system &contact_bias(F f)
  {
    return keep(NSDAE_CALLBACK(contact_bias), std::move(f));
  }
  /* Accelerations at v' = 0 of contacts, omega_n [k] and omega_t [k nt], and of frictional
   * joints, omega_s [f]: g_N'' = W_N^T v' + omega_n, v_T' = W_T^T v' + omega_t,
   * v_S' = W_S^T v' + omega_s.
   * An empty array is NULL.
   *   f(double t, const double *q, const double *v, double *omega_n, double *omega_t,
         double *omega_s) */
  template <class F> system &contact_acceleration(F f)
  {
    return keep(NSDAE_CALLBACK(contact_acceleration), std::move(f));
  }
  /* W_S(t,q) [nv x f] and w_S(t,q) [f]: the slip velocity of each frictional joint is
   * v_S = W_S^T v + w_S.
   *   f(double t, const double *q, double *W, int ldw, double *w_s) */
  template <class F> system &frictional_joint_tangent(F f)
  {
    return keep(NSDAE_CALLBACK(frictional_joint_tangent), std::move(f));
  }
  /* b(t,q,v) [f]: what varies of the bounds of the frictional joints, at least 0. It is added to
   * the constant ones of nsdae_system_set_friction_bound. A jump in time belongs at the end of a
   * step.
   *   f(double t, const double *q, const double *v, double *bound) */
  template <class F> system &joint_friction_bound(F f)
  {
    return keep(NSDAE_CALLBACK(joint_friction_bound), std::move(f));
  }
  /* dq/dt [nq] from v [nv], linear in v.
   *   f(double t, const double *q, const double *v, double *qdot) */
  template <class F> system &kinematics(F f)
  {
    return keep(NSDAE_CALLBACK(kinematics), std::move(f));
  }
  /* Potential energy U(t,q); used in energy reports only.
   *   f(double t, const double *q, double *energy) */
  template <class F> system &potential(F f)
  {
    return keep(NSDAE_CALLBACK(potential), std::move(f));
  }
  /* Upper bound of |d g_N / dt| at (t,q,v) of every contact that a contact list can have. Methods
   * event and penalty derive from it the reach of a step. Without it they estimate the bound.
   *   f(double t, const double *q, const double *v, double *speed) */
  template <class F> system &contact_speed(F f)
  {
    return keep(NSDAE_CALLBACK(contact_speed), std::move(f));
  }
  /* callbacks.list: end */

  /* nsdae_system_set_blocks: block b has nq[b] coordinates and nv[b] velocities. */
  system &blocks(const std::vector<int> &nq, const std::vector<int> &nv)
  {
    if (nq.size() != nv.size())
      throw error(detail::make_record(NSDAE_E_ARGUMENT, "nv", "nq and nv differ in size"));
    return took(nsdae_system_set_blocks(c(), static_cast<int>(nq.size()), nq.data(), nv.data()));
  }
  /* Number of blocks: 1 by default. */
  int blocks() const noexcept
  {
    return nsdae_system_get_blocks(c());
  }
  /* Diagonal blocks of M(t,q), one after another.
   *   f(double t, const double *q, double *M) */
  template <class F> system &mass_blocks(F f)
  {
    return keep(NSDAE_CALLBACK(mass_blocks), std::move(f));
  }
  /* Phi_q(t,q), in place of constraint_jacobian: calls nsdae_row_add for every block of every row.
   *   f(double t, const double *q, nsdae_row_list *rows) */
  template <class F> system &constraint_rows(F f)
  {
    return keep(NSDAE_CALLBACK(constraint_rows), std::move(f));
  }
  /* W_S^T(t,q) and w_s [f], in place of frictional_joint_tangent: calls nsdae_row_add for every
   * block of the row of every frictional joint.
   *   f(double t, const double *q, nsdae_row_list *rows, double *w_s) */
  template <class F> system &joint_friction_rows(F f)
  {
    return keep(NSDAE_CALLBACK(joint_friction_rows), std::move(f));
  }
  /* D = -dF/dv by blocks: calls nsdae_block_add for every block that is not zero.
   *   f(double t, const double *q, const double *v, nsdae_block_list *blocks) */
  template <class F> system &force_damping_blocks(F f)
  {
    return keep(NSDAE_CALLBACK(force_damping_blocks), std::move(f));
  }
  /* K = -(dF/dq) H by blocks, as force_damping_blocks. */
  template <class F> system &force_stiffness_blocks(F f)
  {
    return keep(NSDAE_CALLBACK(force_stiffness_blocks), std::move(f));
  }
  /* In place of fixed contacts: calls nsdae_contact_add for every contact with a gap of at most
   * reach.
   *   f(double t, const double *q, const double *v, double reach, nsdae_contact_list *list) */
  template <class F> system &contacts(F f)
  {
    return keep(NSDAE_CALLBACK(contacts), std::move(f));
  }
#undef NSDAE_CALLBACK

  /* nsdae_system_set_contact: coefficients of contact i, from 0. */
  system &contact(int i, double mu, double e_n, double e_t = 0)
  {
    return took(nsdae_system_set_contact(c(), i, mu, e_n, e_t));
  }
  /* nsdae_system_set_frictional_joint: frictional joint j has this constraint, both from 0. */
  system &frictional_joint(int j, int constraint, double mu)
  {
    return took(nsdae_system_set_frictional_joint(c(), j, constraint, mu));
  }
  /* nsdae_system_set_friction_bound: bound of the friction of frictional joint j, from 0. */
  system &friction_bound(int j, double bound)
  {
    return took(nsdae_system_set_friction_bound(c(), j, bound));
  }
  /* nsdae_system_set_friction_circle: friction radius |lambda| of frictional joint j, lambda of
   * rows constraints from this one on, all from 0. */
  system &friction_circle(int j, int constraint, int rows, double radius)
  {
    return took(nsdae_system_set_friction_circle(c(), j, constraint, rows, radius));
  }
  /* nsdae_system_set_name: kind is an enum nsdae_name_kind, i is from 0. */
  system &name(int kind, int i, const std::string &name, const std::string &unit = std::string())
  {
    return took(nsdae_system_set_name(c(), kind, i, name.c_str(), unit.c_str()));
  }
  /* nsdae_system_set_size: kind is NSDAE_NAME_CONTACT or NSDAE_NAME_CONSTRAINT, i is from 0. */
  system &size(int kind, int i, double size)
  {
    return took(nsdae_system_set_size(c(), kind, i, size));
  }
  /* Name of object i of a kind; empty if not set. */
  std::string name(int kind, int i) const
  {
    return nsdae_system_get_name(c(), kind, i);
  }
  /* nsdae_system_add_body: a body in trajectory files. */
  system &add_body(const nsdae_body &body)
  {
    return took(nsdae_system_add_body(c(), &body));
  }
  /* nsdae_system_get_bodies: texts and points belong to the system. */
  std::vector<nsdae_body> bodies() const
  {
    int n = 0;
    const nsdae_body *first = nsdae_system_get_bodies(c(), &n);
    return std::vector<nsdae_body>(first, first + n);
  }
  /* Unit of object i of a kind; empty if not set. */
  std::string unit(int kind, int i) const
  {
    return nsdae_system_get_unit(c(), kind, i);
  }

  /* Number of existing simulations; the system is constant while there are any. */
  int simulations() const noexcept
  {
    return nsdae_system_simulations(c());
  }

  /* Sizes of the system. */
  nsdae_dims dims() const
  {
    nsdae_dims dims = nsdae_dims();
    detail::demand(nsdae_system_get_dims(c(), &dims), nullptr);
    return dims;
  }
  /* nsdae_system_differences: terms computed by central differences. */
  std::string differences() const
  {
    return nsdae_system_differences(c());
  }

  /* nsdae_system_unseen: properties of the callbacks that no check can verify. */
  std::string unseen() const
  {
    return nsdae_system_unseen(c());
  }

  /* nsdae_system_check at (t, q [nq], v [nv]). */
  int try_check(double t, const double *q, const double *v, double tol,
                nsdae_check *worst = nullptr) noexcept
  {
    return detail::attempt([&] { return nsdae_system_check(c(), t, q, v, tol, worst); });
  }
  /* nsdae_system_check; the error names the wrong entry. */
  void check(double t, const std::vector<double> &q, const std::vector<double> &v,
             double tol = 1e-5)
  {
    const nsdae_dims size = dims();
    const double *at = detail::sized(q, size.nq, "q"), *speed = detail::sized(v, size.nv, "v");
    detail::demand_run(try_check(t, at, speed, tol), last_error());
  }

  /* Error record of the last call. */
  const nsdae_error *last_error() const noexcept
  {
    return nsdae_system_error(c());
  }

private:
  friend class sim;
  friend class bodies;
  std::shared_ptr<detail::system_guts> guts_;

  template <class Callback, class Set, class Run, class F>
  system &keep(Callback detail::system_guts::*member, Set set, Run run, F f)
  {
    Callback callback(std::move(f));
    took(set(c(), run));
    std::swap((*guts_).*member, callback);
    return *this;
  }
  /* Status of a setter. An exception is not stored as an error of the system. */
  system &took(int status)
  {
    if (status >= 0) return *this;
    const nsdae_error record = *last_error();
    nsdae_system_clear_error(c());
    throw error(record);
  }
};

/* nsdae_user_rows: the user's own coordinates and rows beside bodies. Its callbacks are those of
 * system. */
class user_rows
{
public:
  /* Sizes of the user rows. */
  explicit user_rows(const nsdae_dims &dims)
      : c_(nsdae_user_rows()), guts_(std::make_shared<detail::system_guts>())
  {
    c_.dims = dims;
    c_.user = guts_.get();
  }

#define NSDAE_OWN(name)                                                                            \
  template <class F> user_rows &name(F f)                                                          \
  {                                                                                                \
    typedef decltype(detail::system_guts::name) callback;                                          \
    guts_->name = callback(std::move(f));                                                          \
    c_.name =                                                                                      \
        detail::trampoline<decltype(&detail::system_guts::name), &detail::system_guts::name>::run; \
    return *this;                                                                                  \
  }
  NSDAE_OWN(mass)
  NSDAE_OWN(force)
  NSDAE_OWN(constraint)
  NSDAE_OWN(constraint_jacobian)
  NSDAE_OWN(constraint_bias)
  NSDAE_OWN(gap)
  NSDAE_OWN(gap_normal)
  NSDAE_OWN(gap_tangent)
  NSDAE_OWN(contact_bias)
  NSDAE_OWN(contact_acceleration)
  NSDAE_OWN(frictional_joint_tangent)
  NSDAE_OWN(kinematics)
  NSDAE_OWN(constraint_rows)
  NSDAE_OWN(contacts)
  NSDAE_OWN(potential)
#undef NSDAE_OWN

private:
  friend class bodies;
  nsdae_user_rows c_;
  std::shared_ptr<detail::system_guts> guts_;
};

namespace detail
{

/* A struct of C with memory of its own. */
template <class T, void (*release)(T *)> class owner
{
public:
  owner() : c_(T()) {}
  /* The source becomes empty. */
  owner(owner &&other) noexcept : c_(other.c_) { other.c_ = T(); }
  /* The source gets what was here. */
  owner &operator=(owner &&other) noexcept
  {
    std::swap(c_, other.c_);
    return *this;
  }
  ~owner() { release(&c_); }

  /* The struct of C. */
  T *operator->() noexcept { return &c_; }
  /* The struct of C. */
  const T &c() const noexcept { return c_; }

protected:
  T c_;
};

} // namespace detail

/* nsdae_scene of a file. */
class scene : public detail::owner<nsdae_scene, nsdae_scene_release>
{
public:
  /* nsdae_scene_read. */
  explicit scene(const std::string &path)
  {
    nsdae_error record = nsdae_error();
    detail::demand(nsdae_scene_read(path.c_str(), &c_, &record), &record);
  }
};

/* nsdae_solid of a mesh file; bodies::solid takes c(). */
class mesh : public detail::owner<nsdae_solid, nsdae_solid_release>
{
public:
  /* nsdae_solid_read. */
  explicit mesh(const std::string &path, double scale = 1)
  {
    nsdae_error record = nsdae_error();
    detail::demand(nsdae_solid_read(path.c_str(), scale, &c_, &record), &record);
  }
};

/* nsdae_bodies. Members that add an object return its number, or throw. Copies refer to the same
 * mechanism. */
class bodies
{
public:
  /* An empty handle. */
  bodies() noexcept = default;
  /* An empty model of dimension 2 or 3. */
  explicit bodies(int dimension) : guts_(std::make_shared<detail::bodies_guts>())
  {
    nsdae_error record = nsdae_error();
    detail::demand(nsdae_bodies_create(dimension, &guts_->c, &record), &record);
  }

  /* Whether the handle is not empty. */
  explicit operator bool() const noexcept { return c() != nullptr; }
  /* The handle of C, or NULL. */
  nsdae_bodies *c() const noexcept { return guts_ ? guts_->c : nullptr; }

  /* nsdae_bodies_add. */
  int add(const nsdae_rigid_body &body) { return demand(nsdae_bodies_add(c(), &body)); }
  /* A body of solids of one density: nsdae_body_from_solids, nsdae_bodies_add and
   * nsdae_bodies_add_solid. */
  int add(nsdae_rigid_body body, std::vector<nsdae_solid> solids, double density)
  {
    const std::vector<double> densities(solids.size(), density);
    nsdae_error why;
    int status = nsdae_body_from_solids(static_cast<int>(solids.size()), solids.data(),
                                        densities.data(), &body, &why);
    if (status < 0) throw error(why);
    int number = add(body);
    for (const nsdae_solid &s : solids) solid(number, s);
    return number;
  }
  /* nsdae_bodies_add_joint. */
  int joint(const nsdae_joint &joint) { return demand(nsdae_bodies_add_joint(c(), &joint)); }
  /* nsdae_bodies_add_joint with a drive: f(double t, double *drive [3]). */
  template <class F> int joint(nsdae_joint joint, F f)
  {
    guts_->drives.emplace_back(std::move(f));
    joint.drive = detail::bodies_guts::run_drive;
    joint.user = &guts_->drives.back();
    return demand(nsdae_bodies_add_joint(c(), &joint));
  }
  /* nsdae_bodies_add_spring. */
  int spring(const nsdae_spring &spring) { return demand(nsdae_bodies_add_spring(c(), &spring)); }
  /* nsdae_bodies_add_torsion. */
  int torsion(const nsdae_torsion &torsion)
  {
    return demand(nsdae_bodies_add_torsion(c(), &torsion));
  }
  /* nsdae_bodies_add_limit. */
  int limit(const nsdae_limit &limit) { return demand(nsdae_bodies_add_limit(c(), &limit)); }
  /* nsdae_bodies_add_rope. */
  int rope(const nsdae_rope &rope) { return demand(nsdae_bodies_add_rope(c(), &rope)); }
  /* nsdae_bodies_add_coupler. */
  int coupler(const nsdae_coupler &coupler)
  {
    return demand(nsdae_bodies_add_coupler(c(), &coupler));
  }
  /* nsdae_bodies_add_motor. */
  int motor(const nsdae_motor &motor) { return demand(nsdae_bodies_add_motor(c(), &motor)); }
  /* nsdae_bodies_add_motor with a target: f(double t, double *drive [3]). */
  template <class F> int motor(nsdae_motor motor, F f)
  {
    guts_->drives.emplace_back(std::move(f));
    motor.drive = detail::bodies_guts::run_drive;
    motor.user = &guts_->drives.back();
    return demand(nsdae_bodies_add_motor(c(), &motor));
  }
  /* The same with a limit that varies: f(double t, double *drive [3]). */
  template <class F, class G> int motor(nsdae_motor motor, F target, G limit)
  {
    guts_->drives.emplace_back(std::move(limit));
    motor.vary = detail::bodies_guts::run_drive;
    motor.vary_user = &guts_->drives.back();
    return this->motor(motor, std::move(target));
  }
  /* nsdae_bodies_add_sensor. */
  int sensor(const nsdae_sensor &sensor) { return demand(nsdae_bodies_add_sensor(c(), &sensor)); }
  /* nsdae_bodies_add_joint_spring. */
  int joint_spring(const nsdae_joint_spring &spring)
  {
    return demand(nsdae_bodies_add_joint_spring(c(), &spring));
  }
  /* nsdae_bodies_add_load: f(double t, const double *position, const double *velocity, double
   * *force, double *torque). */
  template <class F> int load(int body, const double *point, F f)
  {
    guts_->loads.emplace_back(std::move(f));
    return demand(nsdae_bodies_add_load(c(), body, point, detail::bodies_guts::run_load,
                                        &guts_->loads.back()));
  }
  /* nsdae_bodies_add_solid. */
  int solid(int body, const nsdae_solid &solid)
  {
    return demand(nsdae_bodies_add_solid(c(), body, &solid));
  }
  /* nsdae_bodies_add_contact. */
  int contact(int solid0, int solid1, double mu, double e_n, double e_t = 0)
  {
    return demand(nsdae_bodies_add_contact(c(), solid0, solid1, mu, e_n, e_t));
  }
  /* nsdae_bodies_set_pair. */
  bodies &pair(int material0, int material1, double mu, double e_n, double e_t = 0)
  {
    demand(nsdae_bodies_set_pair(c(), material0, material1, mu, e_n, e_t));
    return *this;
  }
  /* nsdae_bodies_set_name. */
  bodies &name(nsdae_named kind, int i, const std::string &name)
  {
    demand(nsdae_bodies_set_name(c(), kind, i, name.c_str()));
    return *this;
  }
  /* nsdae_bodies_set_colour: "#rrggbb". */
  void set_colour(int kind, int i, const std::string &colour)
  {
    demand(nsdae_bodies_set_colour(c(), kind, i, colour.c_str()));
  }
  /* nsdae_bodies_material. */
  int material(const std::string &name) { return demand(nsdae_bodies_material(c(), name.c_str())); }
  /* nsdae_bodies_set_gravity. */
  bodies &gravity(double x, double y, double z = 0)
  {
    const double g[3] = {x, y, z};
    demand(nsdae_bodies_set_gravity(c(), g));
    return *this;
  }

  /* nsdae_bodies_add_scene. */
  bodies &add_scene(const nsdae::scene &scene)
  {
    demand(nsdae_bodies_add_scene(c(), &scene.c()));
    return *this;
  }

  /* nsdae_bodies_set_user_rows. */
  bodies &set_user_rows(const nsdae::user_rows &part)
  {
    demand(nsdae_bodies_set_user_rows(c(), &part.c_));
    guts_->own = part.guts_;
    return *this;
  }

  /* nsdae_bodies_system; the system keeps the model and its callbacks. A warning is in last_error.
   */
  nsdae::system system() const
  {
    nsdae::system made;
    made.guts_ = std::make_shared<detail::system_guts>();
    made.guts_->world = guts_;
    demand(nsdae_bodies_system(c(), &made.guts_->c));
    return made;
  }
  /* nsdae_bodies_get_dims. */
  nsdae_dims dims() const
  {
    nsdae_dims size = nsdae_dims();
    demand(nsdae_bodies_get_dims(c(), &size));
    return size;
  }
  /* nsdae_bodies_get_start: q [nq], v [nv]. */
  std::pair<std::vector<double>, std::vector<double>> start() const
  {
    const nsdae_dims size = dims();
    std::vector<double> q(static_cast<std::size_t>(size.nq)), v(static_cast<std::size_t>(size.nv));
    demand(nsdae_bodies_get_start(c(), q.data(), v.data()));
    return {q, v};
  }
  /* Error record of the first call that failed, or the warning of system. */
  const nsdae_error *last_error() const noexcept { return nsdae_bodies_error(c()); }

private:
  std::shared_ptr<detail::bodies_guts> guts_;

  int demand(int status) const { return detail::demand(status, last_error()); }
};

/* nsdae_sim. */
class sim
{
public:
  /* An empty handle. */
  sim() noexcept = default;
  /* A simulation of a system, which it keeps alive. */
  explicit sim(const system &of, const options &with = options())
  {
    nsdae_error record = nsdae_error();
    detail::demand(try_create(of, with, &record), &record);
  }
  /* The source becomes empty. */
  sim(sim &&) noexcept = default;
  /* The source becomes empty. */
  sim &operator=(sim &&) noexcept = default;

  /* Creates a new simulation; frees the old one. */
  int try_create(const system &of, const options &with = options(),
                 nsdae_error *record = nullptr) noexcept
  {
    guts_.reset();
    return detail::attempt([&] {
      std::shared_ptr<detail::sim_guts> guts = std::make_shared<detail::sim_guts>();
      guts->system = of.guts_;
      int status = nsdae_sim_create(of.c(), with.c(), &guts->c, record);
      if (status >= 0) guts_ = guts;
      return status;
    });
  }

  /* Whether the handle is not empty. */
  explicit operator bool() const noexcept { return c() != nullptr; }
  /* The handle of C, or NULL. */
  nsdae_sim *c() const noexcept { return guts_ ? guts_->c : nullptr; }

  /* nsdae_sim_project, of q0 [nq] and v0 [nv]. */
  int try_project(double t0, double *q0, double *v0) noexcept
  {
    return use([&](nsdae_sim *c) { return nsdae_sim_project(c, t0, q0, v0); });
  }
  /* nsdae_sim_project: q0 [nq], v0 [nv] are std::vector, std::array or any type with data() and
   * size(). */
  template <class Q, class V> void project(double t0, Q &q0, V &v0)
  {
    const nsdae_dims size = dims();
    detail::sized(q0, size.nq, "q0");
    detail::sized(v0, size.nv, "v0");
    demand_run(try_project(t0, q0.data(), v0.data()));
  }
  /* nsdae_sim_init, of q0 [nq] and v0 [nv]. */
  int try_init(double t0, const double *q0, const double *v0) noexcept
  {
    return use([&](nsdae_sim *c) { return nsdae_sim_init(c, t0, q0, v0); });
  }
  /* nsdae_sim_init: q0 [nq], v0 [nv] are std::vector, std::array or any type with data() and
   * size(). */
  template <class Q, class V> void init(double t0, const Q &q0, const V &v0)
  {
    const nsdae_dims size = dims();
    const double *q = detail::sized(q0, size.nq, "q0"), *v = detail::sized(v0, size.nv, "v0");
    demand_run(try_init(t0, q, v));
  }
  /* nsdae_sim_init of lists: sim.init(0, {1, 2}, {0, 0}). */
  void init(double t0, const std::vector<double> &q0, const std::vector<double> &v0)
  {
    init<std::vector<double>, std::vector<double>>(t0, q0, v0);
  }

  /* nsdae_sim_observe: f(const nsdae_record &) returns void, or 0 to continue, > 0 to stop, < 0 to
   * fail. */
  template <class F> sim &observe(F f)
  {
    typedef detail::sim_guts guts;
    std::unique_ptr<guts::observer> observer(new guts::observer(std::move(f)));
    if (guts_) guts_->observers.reserve(guts_->observers.size() + 1);
    demand(nsdae_sim_observe(c(), guts::observe, observer.get()));
    guts_->observers.push_back(std::move(observer));
    return *this;
  }

  /* nsdae_sim_set_interrupt: f() returns 0 to continue; otherwise the current step fails with
   * NSDAE_E_INTERRUPTED. It is called before every step and after every internal step of penalty
   * and event. */
  template <class F> sim &interrupt(F f)
  {
    std::unique_ptr<detail::callback<>> asked(new detail::callback<>(std::move(f)));
    demand(nsdae_sim_set_interrupt(c(), detail::sim_guts::ask, asked.get()));
    guts_->interrupt = std::move(asked);
    return *this;
  }

  /* nsdae_sim_step. */
  int try_step() noexcept
  {
    return move([&](nsdae_sim *c) { return nsdae_sim_step(c); });
  }
  /* nsdae_sim_run. */
  int try_run(double t_end) noexcept
  {
    return move([&](nsdae_sim *c) { return nsdae_sim_run(c, t_end); });
  }
  /* nsdae_sim_step; returns the status >= 0. */
  int step() { return demand_run(try_step()); }
  /* nsdae_sim_run; returns the status >= 0. */
  int run(double t_end) { return demand_run(try_run(t_end)); }

  /* nsdae_sim_run_to_event. */
  int try_run_to_event(double t_end) noexcept
  {
    return move([&](nsdae_sim *c) { return nsdae_sim_run_to_event(c, t_end); });
  }
  /* nsdae_sim_run_to_event; returns the status >= 0. */
  int run_to_event(double t_end) { return demand_run(try_run_to_event(t_end)); }

  /* nsdae_sim_interpolate: q and v at a time of the last step. */
  void interpolate(double t, std::vector<double> &q, std::vector<double> &v)
  {
    const nsdae_dims size = dims();
    q.resize(static_cast<std::size_t>(size.nq));
    v.resize(static_cast<std::size_t>(size.nv));
    demand_run(use([&](nsdae_sim *c) { return nsdae_sim_interpolate(c, t, q.data(), v.data()); }));
  }

  /* nsdae_sim_set_options. */
  void set_options(const options &with)
  {
    demand(use([&](nsdae_sim *c) { return nsdae_sim_set_options(c, with.c()); }));
  }
  /* nsdae_sim_set_contact: coefficients of fixed contact i in this simulation. */
  void set_contact(int i, double mu, double e_n, double e_t = 0)
  {
    demand(nsdae_sim_set_contact(c(), i, mu, e_n, e_t));
  }
  /* nsdae_sim_set_frictional_joint: friction of frictional joint j in this simulation. */
  void set_frictional_joint(int j, double mu)
  {
    demand(nsdae_sim_set_frictional_joint(c(), j, mu));
  }
  /* nsdae_sim_set_friction_bound: bound of frictional joint j in this simulation. */
  void set_friction_bound(int j, double bound)
  {
    demand(nsdae_sim_set_friction_bound(c(), j, bound));
  }

  /* nsdae_sim_set_control: the target of motor i in this simulation. */
  void set_control(int i, double value) { demand(nsdae_sim_set_control(c(), i, value)); }

  /* nsdae_sim_get_control. */
  double control(int i)
  {
    double value = 0;
    demand(nsdae_sim_get_control(c(), i, &value));
    return value;
  }

  /* nsdae_sim_get_sensor: the values of sensor i at the present record. */
  std::vector<double> sensor(int i)
  {
    double value[NSDAE_VALUES_MAX];
    demand(nsdae_sim_get_sensor(c(), i, value));
    return std::vector<double>(value,
                               value + nsdae_system_sensor_size(nsdae_sim_get_system(c()), i));
  }

  /* nsdae_sim_get_contact_forces: points [3 count] and forces [3 count]. */
  std::pair<std::vector<double>, std::vector<double>> contact_forces()
  {
    const std::size_t size = 3 * static_cast<std::size_t>(record().contacts.count);
    std::vector<double> point(size), force(size);
    demand(nsdae_sim_get_contact_forces(c(), point.data(), force.data()));
    return {point, force};
  }

  /* nsdae_sim_get_state: the state as a block of bytes. */
  std::vector<unsigned char> state() const
  {
    std::size_t size = 0;
    demand(nsdae_sim_state_size(c(), &size));
    std::vector<unsigned char> block(size);
    demand(nsdae_sim_get_state(c(), block.data(), size));
    return block;
  }
  /* nsdae_sim_set_state: continues from a block of state(). */
  int try_set_state(const std::vector<unsigned char> &block) noexcept
  {
    return use([&](nsdae_sim *c) { return nsdae_sim_set_state(c, block.data(), block.size()); });
  }
  /* nsdae_sim_set_state; the error names the reason. */
  void set_state(const std::vector<unsigned char> &block) { demand(try_set_state(block)); }

  /* nsdae_sim_get_record; its pointers are valid until the next step. */
  nsdae_record record() const { return get<nsdae_record>(nsdae_sim_get_record); }
  /* nsdae_sim_get_stats. */
  nsdae_stats stats() const { return get<nsdae_stats>(nsdae_sim_get_stats); }
  /* nsdae_sim_get_dims. */
  nsdae_dims dims() const { return get<nsdae_dims>(nsdae_sim_get_dims); }

  /* Error record of the last call. */
  const nsdae_error *last_error() const noexcept { return nsdae_sim_error(c()); }

private:
  friend class trajectory;
  std::shared_ptr<detail::sim_guts> guts_;

  /* For every call that may run callbacks: a callback that replaces this handle does not free the
   * simulation that calls it. */
  template <class Call> int use(Call call) noexcept
  {
    const std::shared_ptr<detail::sim_guts> kept = guts_;
    return detail::attempt([&] { return call(kept ? kept->c : nullptr); });
  }
  /* use() of a run or a step, whose status is stored. */
  template <class Call> int move(Call call) noexcept
  {
    const std::shared_ptr<detail::sim_guts> kept = guts_;
    const int status = use(call);
    if (kept) kept->status = status;
    return status;
  }
  int demand(int status) const { return detail::demand(status, last_error()); }
  int demand_run(int status) const { return detail::demand_run(status, last_error()); }
  template <class T> T get(int (*from)(const nsdae_sim *, T *)) const
  {
    T value = T();
    detail::demand(from(c(), &value), nullptr);
    return value;
  }
};

/* nsdae_trajectory. The destructor closes the file with the status of the simulation's last run or
 * step. close() also reports write errors. */
class trajectory
{
public:
  /* An empty handle. */
  trajectory() noexcept = default;
  /* Writes the records of the simulation from now on, with the name of the model. */
  trajectory(const sim &of, const std::string &path, const std::string &model = std::string())
  {
    nsdae_trajectory_info info = nsdae_trajectory_info();
    info.model = model.c_str();
    create(of, path, info);
  }
  /* nsdae_trajectory_create with all settings. */
  trajectory(const sim &of, const std::string &path, const nsdae_trajectory_info &info)
  {
    create(of, path, info);
  }
  /* The source becomes empty. */
  trajectory(trajectory &&other) noexcept : c_(other.c_), sim_(std::move(other.sim_))
  {
    other.c_ = nullptr;
  }
  /* The source has the old file. */
  trajectory &operator=(trajectory &&other) noexcept
  {
    std::swap(c_, other.c_);
    std::swap(sim_, other.sim_);
    return *this;
  }
  /* Calls try_close(). */
  ~trajectory() { try_close(); }

  /* Whether the handle is not empty. */
  explicit operator bool() const noexcept { return c_ != nullptr; }
  /* The handle of C, or NULL. */
  nsdae_trajectory *c() const noexcept { return c_; }

  /* nsdae_trajectory_put: a dataset of the user's own. */
  void put(const std::string &path, const std::vector<double> &values, const std::string &units,
           const std::string &description)
  {
    nsdae_error record = nsdae_error();
    detail::demand(nsdae_trajectory_put(c_, path.c_str(), static_cast<int>(values.size()),
                                        values.data(), units.c_str(), description.c_str(), &record),
                   &record);
  }

  /* nsdae_trajectory_set_bodies. */
  void set_bodies(const std::vector<nsdae_body> &bodies)
  {
    nsdae_error record = nsdae_error();
    detail::demand(
        nsdae_trajectory_set_bodies(c_, static_cast<int>(bodies.size()), bodies.data(), &record),
        &record);
  }

  /* nsdae_trajectory_resume: continues the file of an earlier run. */
  static trajectory resume(const sim &of, const std::string &path,
                           const nsdae_trajectory_info &info)
  {
    trajectory made;
    nsdae_error record = nsdae_error();
    detail::demand(nsdae_trajectory_resume(of.c(), path.c_str(), &info, &made.c_, &record),
                   &record);
    made.sim_ = of.guts_;
    return made;
  }

  /* nsdae_trajectory_flush. */
  void flush()
  {
    nsdae_error record = nsdae_error();
    detail::demand(nsdae_trajectory_flush(c_, &record), &record);
  }

  /* nsdae_trajectory_close. */
  int try_close(nsdae_error *record = nullptr) noexcept
  {
    int status = c_ ? nsdae_trajectory_close(&c_, sim_->status, record) : NSDAE_OK;
    if (!c_) sim_.reset(); /* else the call was refused */
    return status;
  }
  /* nsdae_trajectory_close; the error says which data were not written. */
  void close()
  {
    nsdae_error record = nsdae_error();
    detail::demand(try_close(&record), &record);
  }

private:
  nsdae_trajectory *c_ = nullptr;
  std::shared_ptr<detail::sim_guts> sim_;

  void create(const sim &of, const std::string &path, const nsdae_trajectory_info &info)
  {
    nsdae_error record = nsdae_error();
    detail::demand(nsdae_trajectory_create(of.c(), path.c_str(), &info, &c_, &record), &record);
    sim_ = of.guts_;
  }
};

} // namespace nsdae
#endif
