#include "system.hpp"

#include <climits>
#include <stdexcept>
#include <tuple>

#include <nanobind/stl/string.h>

#include "failure.hpp"

namespace nsdae_python
{

namespace
{

const char *const role_name[] = {
#define NSDAE_PYTHON_ROLE(name) #name,
    NSDAE_PYTHON_ROLES(NSDAE_PYTHON_ROLE)
#undef NSDAE_PYTHON_ROLE
};

// Numbers in the diagonal blocks of M.
int squares(const partition &blocks)
{
  double sum = 0;
  for (int n : blocks.nv) sum += static_cast<double>(n) * n;
  if (sum > INT_MAX) throw std::invalid_argument("the blocks of M have more than 2^31 - 1 entries");
  return static_cast<int>(sum);
}

// The arrays of a callback, in the order of its arguments.
std::vector<slot> slots_of(role r, const nsdae_dims &d, const partition &blocks)
{
  const slot q = {d.nq, 0, false}, v = {d.nv, 0, false};
  const auto out = [](int rows) { return slot{rows, 0, true}; };
  const auto matrix = [](int rows, int columns) { return slot{rows, columns, true}; };
  switch (r) {
  case role_mass:
    return {q, matrix(d.nv, d.nv)};
  case role_force:
    return {q, v, out(d.nv)};
  case role_force_damping:
  case role_force_stiffness:
    return {q, v, matrix(d.nv, d.nv)};
  case role_constraint:
    return {q, out(d.m)};
  case role_constraint_jacobian:
    return {q, matrix(d.m, d.nv)};
  case role_constraint_bias:
    return {q, v, out(d.m), out(d.m)};
  case role_gap:
    return {q, out(d.k)};
  case role_gap_normal:
    return {q, matrix(d.nv, d.k)};
  case role_gap_tangent:
    return {q, matrix(d.nv, d.k * d.nt)};
  case role_contact_bias:
    return {q, out(d.k), out(d.k * d.nt)};
  case role_contact_acceleration:
    return {q, v, out(d.k), out(d.k * d.nt), out(d.f)};
  case role_frictional_joint_tangent:
    return {q, matrix(d.nv, d.f), out(d.f)};
  case role_joint_friction_bound:
    return {q, v, out(d.f)};
  case role_kinematics:
    return {q, v, out(d.nq)};
  case role_mass_blocks:
    return {q, out(squares(blocks))};
  case role_constraint_rows:
    return {q};
  case role_joint_friction_rows:
    return {q, out(d.f)};
  case role_force_damping_blocks:
  case role_force_stiffness_blocks:
  case role_contacts:
    return {q, v};
  case role_contact_speed:
    return {q, v, out(1)};
  default:
    return {q, out(1)}; // potential: its value
  }
}

role role_of(const std::string &name)
{
  for (int r = 0; r < roles; r++)
    if (name == role_name[r]) return static_cast<role>(r);
  throw std::invalid_argument("no callback is called '" + name + "'");
}

// user is the table of callbacks.
template <int R, class... A> int to_python(A... a)
{
  void *table = std::get<sizeof...(A) - 1>(std::tie(a...));
  call c((*static_cast<std::array<callback, roles> *>(table))[R]);
  (c.put(a), ...);
  return c.run();
}

template <int R, class... A> int to_compiled(A... a)
{
  auto arguments = std::make_tuple(a...);
  void *&user = std::get<sizeof...(A) - 1>(arguments);
  const callback &c = (*static_cast<std::array<callback, roles> *>(user))[R];
  user = c.user;
  return std::apply(reinterpret_cast<int (*)(A...)>(c.pointer), arguments);
}

template <int R, class... A>
int install_one(system &s, bool direct, int (*set)(nsdae_system *, int (*)(A...)))
{
  const callback &c = s.callbacks[R];
  if (!c.given()) return NSDAE_OK;
  if (c.function) return set(s.handle, to_python<R, A...>);
  return set(s.handle, direct ? reinterpret_cast<int (*)(A...)>(c.pointer) : to_compiled<R, A...>);
}

template <int R, class... A> void fill_one(role_table &table, int (*&to)(A...))
{
  if (table[R].given()) to = table[R].function ? to_python<R, A...> : to_compiled<R, A...>;
}

// A function of Python returns the energy; that of the bodies is in it.
int add_potential(double t, const double *q, double *energy, void *user)
{
  double own = 0;
  const int code = to_python<role_potential>(t, q, &own, user);
  *energy += own;
  return code;
}

} // namespace

void set_user_callback(role_table &table, const std::string &name, nb::object function,
                       std::uintptr_t address, std::uintptr_t user, const nsdae_dims &total,
                       const nsdae_dims &own, const partition &blocks)
{
  const role r = role_of(name);
  const nsdae_dims d = {total.nq, total.nv, own.m, own.k, total.nt, own.f};
  std::vector<slot> slots = slots_of(r, d, blocks);
  if (r == role_mass) slots.back() = {own.nv, own.nv, true};
  if (r == role_kinematics) slots.back() = {own.nq, 0, true};
  callback &c = table[static_cast<std::size_t>(r)];
  if (function.is_none())
    c.set_pointer(reinterpret_cast<void *>(address), reinterpret_cast<void *>(user));
  else
    c.set_function(function.ptr(), slots, r == role_potential);
  c.blocks = &blocks;
}

void fill_user_rows(role_table &table, nsdae_user_rows &rows)
{
#define NSDAE_PYTHON_OWN(name) fill_one<role_##name>(table, rows.name);
  NSDAE_PYTHON_OWN(mass)
  NSDAE_PYTHON_OWN(force)
  NSDAE_PYTHON_OWN(constraint)
  NSDAE_PYTHON_OWN(constraint_jacobian)
  NSDAE_PYTHON_OWN(constraint_bias)
  NSDAE_PYTHON_OWN(gap)
  NSDAE_PYTHON_OWN(gap_normal)
  NSDAE_PYTHON_OWN(gap_tangent)
  NSDAE_PYTHON_OWN(contact_bias)
  NSDAE_PYTHON_OWN(contact_acceleration)
  NSDAE_PYTHON_OWN(frictional_joint_tangent)
  NSDAE_PYTHON_OWN(kinematics)
  NSDAE_PYTHON_OWN(constraint_rows)
  NSDAE_PYTHON_OWN(contacts)
  NSDAE_PYTHON_OWN(potential)
#undef NSDAE_PYTHON_OWN
  if (table[role_potential].function) rows.potential = add_potential;
  rows.user = &table;
}

system::system(int nq, int nv, int m, int k, int nt, int f)
{
  nsdae_error error;
  dims = {nq, nv, m, k, nt, f};
  check(nsdae_system_create(&dims, &handle, &error), &error);
  nsdae_system_get_dims(handle, &dims);
}

system::system(nsdae_system *made, bool listed, nb::object of) : handle(made), bodies(of)
{
  nsdae_system_get_dims(handle, &dims);
  int count = listed ? nsdae_system_get_blocks(handle) : 0;
  for (int b = 0; b < count; b++) {
    blocks.nq.push_back(dims.nq / count);
    blocks.nv.push_back(dims.nv / count);
  }
}

system::~system()
{
  nsdae_system_destroy(&handle);
}

void system::demand(int status)
{
  if (status >= 0) return;
  const nsdae_error error = *nsdae_system_error(handle);
  nsdae_system_clear_error(handle); // the exception has it
  check(status, &error);
}

// A check calls the current callbacks; the system of a simulation is constant.
void system::open() const
{
  if (checking)
    refuse(NSDAE_E_STATE, "system",
           "System.check is in progress, in a callback or in another thread: call it afterwards");
}

int system::install()
{
  bool direct = true;
  void *user = nullptr;
  for (const callback &c : callbacks) {
    direct = direct && !c.function && (!c.pointer || !user || c.user == user);
    if (c.pointer && !user) user = c.user;
  }
  for (const callback &c : callbacks) direct = direct && (!c.pointer || c.user == user);
  int status = nsdae_system_set_user(handle, direct ? user : &callbacks);
#define NSDAE_PYTHON_ROLE(name) \
  if (status == NSDAE_OK) status = install_one<role_##name>(*this, direct, nsdae_system_set_##name);
  NSDAE_PYTHON_ROLES(NSDAE_PYTHON_ROLE)
#undef NSDAE_PYTHON_ROLE
  return status;
}

void system::install_or_drop(role r)
{
  int status = install();
  if (status < 0 && nsdae_system_simulations(handle) == 0) callbacks[r].clear();
  demand(status);
}

// A function of Python, or none: a compiled one at the address.
void system::set_callback(const std::string &name, nb::object function, std::uintptr_t address,
                          std::uintptr_t user)
{
  role r = role_of(name);
  open();
  if (nsdae_system_simulations(handle) == 0) {
    const bool returns = r == role_potential || r == role_contact_speed;
    if (function.is_none())
      callbacks[r].set_pointer(reinterpret_cast<void *>(address), reinterpret_cast<void *>(user));
    else
      callbacks[r].set_function(function.ptr(), slots_of(r, dims, blocks), returns);
    callbacks[r].blocks = &blocks;
  }
  install_or_drop(r);
}

void system::set_contact(int i, double mu, double e_n, double e_t)
{
  demand(nsdae_system_set_contact(handle, i, mu, e_n, e_t));
}

void system::set_frictional_joint(int j, int constraint, double mu)
{
  demand(nsdae_system_set_frictional_joint(handle, j, constraint, mu));
}

void system::set_friction_bound(int j, double bound)
{
  demand(nsdae_system_set_friction_bound(handle, j, bound));
}

void system::set_friction_circle(int j, int constraint, int rows, double radius)
{
  demand(nsdae_system_set_friction_circle(handle, j, constraint, rows, radius));
}

// Before the callbacks: their arrays are of these sizes.
void system::set_blocks(whole_numbers nq, whole_numbers nv)
{
  if (nq.shape(0) != nv.shape(0))
    throw std::invalid_argument("nq and nv of the blocks must be as many");
  open();
  demand(nsdae_system_set_blocks(handle, static_cast<int>(nq.shape(0)), nq.data(), nv.data()));
  blocks.nq.assign(nq.data(), nq.data() + nq.shape(0));
  blocks.nv.assign(nv.data(), nv.data() + nv.shape(0));
  blocks.nt = dims.nt;
}

void system::set_size(int kind, int i, double size)
{
  demand(nsdae_system_set_size(handle, kind, i, size));
}

void system::set_name(int kind, int i, const std::string &name, const std::string &unit)
{
  demand(nsdae_system_set_name(handle, kind, i, text(name, "name"), text(unit, "unit")));
}

nb::tuple system::name(int kind, int i) const
{
  return nb::make_tuple(nb::str(nsdae_system_get_name(handle, kind, i)),
                        nb::str(nsdae_system_get_unit(handle, kind, i)));
}

nb::dict system::check_at(double t, vector q, vector v, double tol)
{
  nsdae_check found;
  if (q.shape(0) != static_cast<std::size_t>(dims.nq) ||
      v.shape(0) != static_cast<std::size_t>(dims.nv))
    throw std::invalid_argument("q and v must have the sizes of the system");
  int status;
  open();
  checking = true;
  {
    library_call without_gil;
    status = nsdae_system_check(handle, t, q.data(), v.data(), tol, &found);
  }
  checking = false;
  const nsdae_error error = *nsdae_system_error(handle);
  nsdae_system_clear_error(handle);
  check(status, &error);
  nb::dict said;
  said["term"] = nb::str(found.term);
  said["row"] = found.row;
  said["column"] = found.column;
  said["given"] = found.given;
  said["difference"] = found.difference;
  said["error"] = found.error;
  return said;
}

namespace
{

// The functions may refer to an owner of the system: the garbage collector has to see them.
int traverse(PyObject *self, visitproc visit, void *arg)
{
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  for (const callback &c : nb::inst_ptr<system>(self)->callbacks) Py_VISIT(c.function);
  Py_VISIT(nb::inst_ptr<system>(self)->bodies.ptr());
  return 0;
}

int clear(PyObject *self)
{
  if (!nb::inst_ready(self)) return 0;
  for (callback &c : nb::inst_ptr<system>(self)->callbacks) c.clear();
  nb::inst_ptr<system>(self)->bodies.reset();
  return 0;
}

PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void *>(traverse)},
                       {Py_tp_clear, reinterpret_cast<void *>(clear)},
                       {0, nullptr}};

} // namespace

void bind_system(nb::module_ &m)
{
  nb::list names;
  for (const char *name : role_name) names.append(name);
  m.attr("CALLBACKS") = nb::tuple(names);
  nb::class_<system>(m, "System", nb::type_slots(slots))
      .def(nb::init<int, int, int, int, int, int>())
      .def("set_callback", &system::set_callback, nb::arg(), nb::arg().none(), nb::arg(), nb::arg())
      .def("set_contact", &system::set_contact)
      .def("set_frictional_joint", &system::set_frictional_joint)
      .def("set_friction_bound", &system::set_friction_bound)
      .def("set_friction_circle", &system::set_friction_circle)
      .def("set_blocks", &system::set_blocks)
      .def("blocks",
           [](const system &s) {
             return nb::make_tuple(array_of(s.blocks.nq), array_of(s.blocks.nv));
           })
      .def("set_size", &system::set_size)
      .def("set_name", &system::set_name)
      .def("name", &system::name)
      .def("check", &system::check_at)
      .def("simulations", [](const system &s) { return nsdae_system_simulations(s.handle); })
      .def("unseen", [](const system &s) { return nb::str(nsdae_system_unseen(s.handle)); })
      .def("differences",
           [](const system &s) { return nb::str(nsdae_system_differences(s.handle)); })
      .def("dims", [](const system &s) {
        return nb::make_tuple(s.dims.nq, s.dims.nv, s.dims.m, s.dims.k, s.dims.nt, s.dims.f);
      });
}

} // namespace nsdae_python
