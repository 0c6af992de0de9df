// nsdae_system with callbacks of Python.
#ifndef NSDAE_PYTHON_SYSTEM_HPP
#define NSDAE_PYTHON_SYSTEM_HPP

#include <array>
#include <string>

#include <nsdae/nsdae.h>

#include "callbacks.hpp"
#include "view.hpp"

namespace nsdae_python
{

// In the order of nsdae/system.h.
// clang-format off
#define NSDAE_PYTHON_ROLES(X) \
  X(mass) X(force) X(force_damping) X(force_stiffness) X(constraint) X(constraint_jacobian) X(constraint_bias) X(gap) X(gap_normal) \
  X(gap_tangent) X(contact_bias) X(contact_acceleration) X(frictional_joint_tangent) X(joint_friction_bound) X(kinematics) \
  X(potential) X(contact_speed) \
  X(mass_blocks) X(constraint_rows) X(joint_friction_rows) X(force_damping_blocks) X(force_stiffness_blocks) X(contacts)
// clang-format on

enum role {
#define NSDAE_PYTHON_ROLE(name) role_##name,
  NSDAE_PYTHON_ROLES(NSDAE_PYTHON_ROLE)
#undef NSDAE_PYTHON_ROLE
      roles
};

// Callbacks by role; the address is the last argument of the functions in C.
using role_table = std::array<callback, roles>;

// Sets a callback of user rows: a function of Python or an address. total: sizes of the whole
// mechanism; own: of the rows.
void set_user_callback(role_table &table, const std::string &name, nb::object function,
                       std::uintptr_t address, std::uintptr_t user, const nsdae_dims &total,
                       const nsdae_dims &own, const partition &blocks);
// The functions in C of those that are given.
void fill_user_rows(role_table &table, nsdae_user_rows &rows);

// A description. Its user pointer is the table of its callbacks. If all callbacks are compiled with
// the same user pointer, the library calls them directly.
class system
{
public:
  system(int nq, int nv, int m, int k, int nt, int f);
  // Takes the system of bodies, which it keeps alive; listed: every body is a block.
  system(nsdae_system *made, bool listed, nb::object of);
  ~system();
  system(const system &) = delete;
  system &operator=(const system &) = delete;

  void set_callback(const std::string &name, nb::object function, std::uintptr_t address,
                    std::uintptr_t user);
  void set_contact(int i, double mu, double e_n, double e_t);
  void set_frictional_joint(int j, int constraint, double mu);
  void set_friction_bound(int j, double bound);
  void set_friction_circle(int j, int constraint, int rows, double radius);
  void set_blocks(whole_numbers nq, whole_numbers nv);
  void set_size(int kind, int i, double size);
  void set_name(int kind, int i, const std::string &name, const std::string &unit);
  nb::dict check_at(double t, vector q, vector v, double tol);
  nb::tuple name(int kind, int i) const;

  nsdae_system *handle = nullptr;
  nsdae_dims dims = {};
  partition blocks;
  role_table callbacks;
  nb::object bodies; // the bodies of the system, or none

private:
  void open() const;
  int install();
  void install_or_drop(role r);
  void demand(int status);
  bool checking = false; // a check calls the callbacks
};

void bind_system(nb::module_ &m);

} // namespace nsdae_python

#endif
