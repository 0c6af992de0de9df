#ifndef NSDAE_PYTHON_PROBLEMS_HPP
#define NSDAE_PYTHON_PROBLEMS_HPP

#include <nanobind/nanobind.h>

namespace nsdae_python
{

void bind_problems(nanobind::module_ &m);

} // namespace nsdae_python

#endif
