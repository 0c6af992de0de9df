#include "sim.hpp"

namespace nsdae_python
{

namespace
{

// np.frombuffer, and the types of rows: those of _records.py
struct {
  PyObject *frombuffer, *number, *whole, *impact, *change, *certificate, *contact[3];
} numpy;

void set_types(nb::dict types)
{
  const auto of = [&](const char *name) { return nb::object(types[name]).release().ptr(); };
  numpy = {of("frombuffer"),
           of("number"),
           of("whole"),
           of("impact"),
           of("change"),
           of("certificate"),
           {of("contact0"), of("contact1"), of("contact2")}};
}

// A copy of n values as an array: over a bytearray, which takes a fifth of the time of an ndarray
// of nanobind.
template <class T> nb::object array_from(const T *values, std::size_t n, PyObject *type)
{
  static const char nothing = 0;
  const char *bytes = n > 0 ? reinterpret_cast<const char *>(values) : &nothing;
  nb::object copy =
      nb::steal(PyByteArray_FromStringAndSize(bytes, static_cast<Py_ssize_t>(n * sizeof(T))));
  if (!copy.is_valid()) throw nb::python_error();
  PyObject *arguments[] = {copy.ptr(), type};
  nb::object array = nb::steal(PyObject_Vectorcall(numpy.frombuffer, arguments, 2, nullptr));
  if (!array.is_valid()) throw nb::python_error();
  return array;
}

template <class T> nb::object array_from(const std::vector<T> &values, PyObject *type)
{
  return array_from(values.data(), values.size(), type);
}

template <class T> void keep(std::vector<T> &to, const T *values, int n)
{
  if (n > 0) to.assign(values, values + n);
}

} // namespace

kept_record::kept_record(const nsdae_record &r, const nsdae_dims &d) : of(r), dims(d)
{
  keep(q, r.q, d.nq);
  keep(v, r.v, d.nv);
  keep(acceleration, r.acceleration, d.nv);
  keep(multiplier, r.multiplier, d.m);
  keep(frictional_joint_impulse, r.frictional_joint_impulse, d.f);
  keep(frictional_joint_mode, r.frictional_joint_mode, d.f);
  events.add_events(r);
  append_contacts(events.contacts, r.contacts, d.nt);
}

nb::object numbers_from(const double *values, int n)
{
  return array_from(values, static_cast<std::size_t>(n), numpy.number);
}

nb::object contacts_from(const std::vector<contact_row> &rows, int nt)
{
  return array_from(rows, numpy.contact[nt]);
}

void bind_records(nb::module_ &m)
{
  m.def("set_types", set_types);
  nb::class_<kept_record> kept(m, "Record");
#define NSDAE_PYTHON_SCALAR(name) \
  kept.def_prop_ro(#name, [](const kept_record &r) { return r.of.name; });
  NSDAE_PYTHON_SCALAR(step)
  NSDAE_PYTHON_SCALAR(time)
  NSDAE_PYTHON_SCALAR(duration)
  NSDAE_PYTHON_SCALAR(kinetic)
  NSDAE_PYTHON_SCALAR(potential)
  NSDAE_PYTHON_SCALAR(dissipated)
  NSDAE_PYTHON_SCALAR(projection_energy)
  NSDAE_PYTHON_SCALAR(lcp_residual)
  NSDAE_PYTHON_SCALAR(contact_tol)
  NSDAE_PYTHON_SCALAR(constraint_drift)
  NSDAE_PYTHON_SCALAR(penetration)
#undef NSDAE_PYTHON_SCALAR
#define NSDAE_PYTHON_ARRAY(name, values, type) \
  kept.def_prop_ro(#name, [](const kept_record &r) { return array_from(r.values, numpy.type); });
  NSDAE_PYTHON_ARRAY(q, q, number)
  NSDAE_PYTHON_ARRAY(v, v, number)
  NSDAE_PYTHON_ARRAY(acceleration, acceleration, number)
  NSDAE_PYTHON_ARRAY(multiplier, multiplier, number)
  NSDAE_PYTHON_ARRAY(frictional_joint_impulse, frictional_joint_impulse, number)
  NSDAE_PYTHON_ARRAY(frictional_joint_mode, frictional_joint_mode, whole)
  NSDAE_PYTHON_ARRAY(impacts, events.impacts, impact)
  NSDAE_PYTHON_ARRAY(changes, events.changes, change)
  NSDAE_PYTHON_ARRAY(contacts, events.contacts, contact[r.dims.nt])
#undef NSDAE_PYTHON_ARRAY
  kept.def_prop_ro("certificate", [](const kept_record &r) {
    nb::object rows = array_from(&r.of.certificate, 1, numpy.certificate);
    return nb::object(rows[0]);
  });
}

} // namespace nsdae_python
