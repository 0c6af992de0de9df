// Linear complementarity and friction problems.
#include "problems.hpp"

#include <exception>
#include <stdexcept>
#include <vector>

#include <nanobind/stl/optional.h>

#include "failure.hpp"
#include "view.hpp"

namespace nsdae_python
{

namespace
{

void check_size(const char *name, std::size_t has, std::size_t wants)
{
  if (has == wants) return;
  throw std::invalid_argument(std::string(name) + " has " + std::to_string(has) + " numbers, not " +
                              std::to_string(wants));
}

// Solved, unsolved or infeasible, as in the outcome; other errors are raised.
void demand(int status, const nsdae_error *error)
{
  if (status != NSDAE_E_LCP && status != NSDAE_E_INFEASIBLE) check(status, error);
}

// (x, y, how) for every outcome.
nb::tuple lcp(matrix A, vector b, std::optional<vector> guess, double tol, int max_pivots,
              int enumerate_max)
{
  const std::size_t n = b.shape(0);
  if (A.shape(0) != n || A.shape(1) != n)
    throw std::invalid_argument("A must be n x n, where b has n numbers");
  if (guess) check_size("x0", guess->shape(0), n);
  nsdae_lcp_options options;
  nsdae_lcp_options_default(&options);
  options.tol = tol;
  options.max_pivots = max_pivots;
  options.enumerate_max = enumerate_max;
  const int rows = static_cast<int>(n);
  const nsdae_lcp_problem problem = {rows, A.data(), rows > 1 ? rows : 1, b.data()};
  std::vector<double> x(n), y(n);
  if (guess) x.assign(guess->data(), guess->data() + n);
  nsdae_lcp_info info = {};
  int status;
  {
    library_call without_gil;
    status = nsdae_lcp_solve(&problem, &options, x.data(), y.data(), &info);
  }
  demand(status, nullptr);
  nb::dict how;
  how["outcome"] = nsdae_outcome_name(info.outcome);
  how["stage"] = nsdae_lcp_stage_name(info.stage);
  how["proof"] = nsdae_proof_name(info.proof);
  how["ray"] = nsdae_lcp_ray_name(info.ray);
  how["pivots"] = info.pivots;
  how["residual"] = info.residual;
  return nb::make_tuple(array_of(x, {n}), array_of(y, {n}), how);
}

// The arrays of nsdae_friction_problem from nsdae._problems. Their sizes are checked here, their
// contents by the library.
struct friction_arrays {
  int form, contacts, bilateral;
  whole_numbers rows;
  vector mu, w, compliance;
  whole_numbers size;
  vector M, f;
  whole_numbers first, block;
  vector value;
};

friction_arrays unpack(nb::dict d)
{
  const auto numbers = [&](const char *name) { return nb::cast<vector>(d[name]); };
  const auto integers = [&](const char *name) { return nb::cast<whole_numbers>(d[name]); };
  return {nb::cast<int>(d["form"]),
          nb::cast<int>(d["contacts"]),
          nb::cast<int>(d["bilateral"]),
          integers("rows"),
          numbers("mu"),
          numbers("w"),
          numbers("compliance"),
          integers("size"),
          numbers("M"),
          numbers("f"),
          integers("first"),
          integers("block"),
          numbers("value")};
}

nb::dict how_of(const nsdae_friction_info &info)
{
  nb::dict how;
  how["outcome"] = nsdae_outcome_name(info.outcome);
  how["stage"] = nsdae_friction_stage_name(info.stage);
  how["proof"] = nsdae_proof_name(info.proof);
  how["islands"] = info.islands;
  how["sweeps"] = info.sweeps;
  how["iterations"] = info.iterations;
  how["factorisations"] = info.factorisations;
  how["residual"] = info.residual;
  return how;
}

// Calls progress, which may be None, and checks for Ctrl-C. Their exceptions end the solve and are
// raised after it.
struct progress_call {
  nb::object call;
  std::exception_ptr raised;
  static int made(const nsdae_friction_progress *now, void *self);
  bool stop(const nsdae_friction_progress &now) const;
};

int progress_call::made(const nsdae_friction_progress *now, void *self)
{
  if (library_call::ending()) return 1;
  auto *p = static_cast<progress_call *>(self);
  nb::gil_scoped_acquire gil;
  try {
    return p->stop(*now);
  } catch (...) {
    p->raised = std::current_exception();
    return 1;
  }
}

bool progress_call::stop(const nsdae_friction_progress &now) const
{
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
  if (call.is_none()) return false;
  nb::dict what;
  what["stage"] = nsdae_friction_stage_name(now.stage);
  what["island"] = now.island;
  what["islands"] = now.islands;
  what["contacts"] = now.contacts;
  what["residual"] = now.residual;
  what["share"] = now.share;
  what["sweeps"] = now.sweeps;
  what["iterations"] = now.iterations;
  return PyObject_IsTrue(call(what).ptr()) != 0;
}

// (r, u, how) for every outcome; how has low for a double-double solution (twice).
nb::tuple friction(nb::dict arrays, std::optional<vector> guess, double tol, int max_sweeps,
                   int max_iterations, double budget, nb::object progress, bool twice)
{
  const friction_arrays a = unpack(arrays);
  const std::size_t m = a.w.shape(0);
  if (guess) check_size("r0", guess->shape(0), m);
  const nsdae_friction_problem problem = {
      a.form,         a.contacts,    a.bilateral,         a.rows.data(),
      a.mu.data(),    a.w.data(),    a.compliance.data(), static_cast<int>(a.size.shape(0)),
      a.size.data(),  a.M.data(),    a.f.data(),          a.first.data(),
      a.block.data(), a.value.data()};
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.tol = tol;
  options.max_sweeps = max_sweeps;
  options.max_iterations = max_iterations;
  options.budget = budget;
  progress_call seen = {progress, nullptr};
  options.progress = progress_call::made;
  options.user = &seen;
  std::vector<double> r(m), u(m), low(m);
  if (guess) r.assign(guess->data(), guess->data() + m);
  nsdae_friction_info info = {};
  nsdae_error error = {};
  int status;
  {
    library_call without_gil;
    status = nsdae_friction_check(&problem, &error);
    if (status == NSDAE_OK)
      status = nsdae_friction_solve_twice(&problem, &options, r.data(),
                                          twice ? low.data() : nullptr, u.data(), &info);
  }
  if (seen.raised) std::rethrow_exception(seen.raised);
  if (status != NSDAE_E_INTERRUPTED) demand(status, &error);
  nb::dict how = how_of(info);
  if (twice) how["low"] = array_of(low, {m});
  return nb::make_tuple(array_of(r, {m}), array_of(u, {m}), how);
}

} // namespace

void bind_problems(nb::module_ &m)
{
  m.def("lcp", &lcp, nb::arg("A"), nb::arg("b"), nb::arg("guess").none(), nb::arg("tol"),
        nb::arg("max_pivots"), nb::arg("enumerate_max"));
  m.def("friction", &friction, nb::arg("arrays"), nb::arg("guess").none(), nb::arg("tol"),
        nb::arg("max_sweeps"), nb::arg("max_iterations"), nb::arg("budget"),
        nb::arg("progress").none(), nb::arg("twice"));
}

} // namespace nsdae_python
