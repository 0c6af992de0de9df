// The extension module of the package, used by nsdae/*.py.
#include <nanobind/nanobind.h>
#include <nsdae/nsdae.h>

#include "bodies.hpp"
#include "failure.hpp"
#include "lists.hpp"
#include "problems.hpp"
#include "sim.hpp"
#include "system.hpp"

NB_MODULE(_core, m)
{
  using namespace nsdae_python;
  // objects kept until the end of the interpreter (daemon threads, extensions) are no leak
  nanobind::set_leak_warnings(false);
  m.attr("VERSION") = nsdae_version();
  m.attr("BUILD_INFO") = nsdae_build_info();
  bind_failure(m);
  bind_lists(m);
  bind_system(m);
  bind_records(m);
  bind_sim(m);
  bind_bodies(m);
  bind_problems(m);
}
