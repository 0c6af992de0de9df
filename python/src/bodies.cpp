#include "bodies.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "failure.hpp"
#include "system.hpp"

namespace nsdae_python
{

namespace
{

int drive_in_python(double t, double drive[3], void *user)
{
  call c(*static_cast<callback *>(user));
  c.put(t);
  c.put(drive);
  return c.run();
}

int load_in_python(double t, const double position[3], const double velocity[3], double force[3],
                   double torque[3], void *user)
{
  call c(*static_cast<callback *>(user));
  c.put(t);
  c.put(position);
  c.put(velocity);
  c.put(force);
  c.put(torque);
  return c.run();
}

template <class T, std::size_t n> void fill(T (&to)[n], const std::array<T, n> &from)
{
  std::copy(from.begin(), from.end(), to);
}

// The solid of a dict with the fields of nsdae_solid; the caller owns point.
nsdae_solid solid_of(nb::dict d, vector &points)
{
  nsdae_solid s = {};
  s.shape = nb::cast<int>(d["shape"]);
  s.radius = nb::cast<double>(d["radius"]);
  s.hollow = nb::cast<bool>(d["hollow"]) ? 1 : 0;
  s.material = nb::cast<int>(d["material"]);
  s.group = nb::cast<int>(d["group"]);
  s.exclude = nb::cast<int>(d["exclude"]);
  s.angle = nb::cast<double>(d["angle"]);
  fill(s.length, nb::cast<triple>(d["length"]));
  fill(s.position, nb::cast<triple>(d["position"]));
  fill(s.quaternion, nb::cast<quadruple>(d["quaternion"]));
  points = nb::cast<vector>(d["points"]);
  s.points = static_cast<int>(points.shape(0)) / (s.shape == NSDAE_SHAPE_POLYGON ? 2 : 3);
  s.point = points.data();
  const auto triangle = nb::cast<nb::ndarray<const int, nb::ndim<1>, nb::c_contig>>(d["triangle"]);
  s.triangles = static_cast<int>(triangle.shape(0)) / 3; // the dict owns them
  s.triangle = triangle.data();
  const auto grid = nb::cast<std::array<int, 2>>(d["grid"]);
  fill(s.grid, grid);
  return s;
}

} // namespace

bodies::bodies(int given) : dimension(given)
{
  nsdae_error error;
  check(nsdae_bodies_create(dimension, &handle, &error), &error);
}

bodies::~bodies()
{
  nsdae_bodies_destroy(&handle);
}

int bodies::demand(int status) const
{
  check(status, nsdae_bodies_error(handle));
  return status;
}

int bodies::add(double mass, triple inertia, triple product, triple position, double angle,
                quadruple quaternion, triple velocity, triple spin)
{
  nsdae_rigid_body b = {};
  b.mass = mass;
  b.angle = angle;
  fill(b.inertia, inertia);
  fill(b.product, product);
  fill(b.position, position);
  fill(b.quaternion, quaternion);
  fill(b.velocity, velocity);
  fill(b.spin, spin);
  return demand(nsdae_bodies_add(handle, &b));
}

// A function of Python, or a compiled one at the address; none: NULL.
void bodies::set_drive(nb::object function, std::uintptr_t address, std::uintptr_t given,
                       nsdae_drive_fn &drive, void *&user)
{
  if (!function.is_none()) {
    functions.emplace_back().set_function(function.ptr(), {{3, 0, true}}, false);
    drive = drive_in_python;
    user = &functions.back();
  } else if (address) {
    drive = reinterpret_cast<nsdae_drive_fn>(address);
    user = reinterpret_cast<void *>(given);
  }
}

int bodies::add_joint(int kind, int body0, int body1, triple point, triple end, triple axis,
                      triple cross, double ratio, double mu, double radius, bool collide_connected,
                      nb::object drive, std::uintptr_t address, std::uintptr_t user)
{
  nsdae_joint j = {};
  j.kind = kind;
  j.body[0] = body0;
  j.body[1] = body1;
  j.ratio = ratio;
  j.mu = mu;
  j.radius = radius;
  j.collide_connected = collide_connected ? 1 : 0;
  fill(j.point, point);
  fill(j.end, end);
  fill(j.axis, axis);
  fill(j.cross, cross);
  set_drive(drive, address, user, j.drive, j.user);
  return demand(nsdae_bodies_add_joint(handle, &j));
}

int bodies::add_limit(int joint, int coordinate, double low, double high, double e_n)
{
  nsdae_limit l = {};
  l.joint = joint;
  l.coordinate = coordinate;
  l.low = low;
  l.high = high;
  l.e_n = e_n;
  return demand(nsdae_bodies_add_limit(handle, &l));
}

int bodies::add_rope(int body0, int body1, triple point, triple end, double length, double e_n)
{
  nsdae_rope r = {};
  r.body[0] = body0;
  r.body[1] = body1;
  r.length = length;
  r.e_n = e_n;
  fill(r.point, point);
  fill(r.end, end);
  return demand(nsdae_bodies_add_rope(handle, &r));
}

int bodies::add_coupler(std::array<int, 2> joint, std::array<int, 2> coordinate,
                        std::array<double, NSDAE_COUPLER_COEFFICIENTS> p)
{
  nsdae_coupler k = {};
  fill(k.joint, joint);
  fill(k.coordinate, coordinate);
  fill(k.p, p);
  return demand(nsdae_bodies_add_coupler(handle, &k));
}

int bodies::add_motor(int joint, int coordinate, int kind, double target, double limit, double kp,
                      double kd, nb::object drive, std::uintptr_t address, std::uintptr_t user,
                      nb::object vary, std::uintptr_t vary_address, std::uintptr_t vary_user)
{
  nsdae_motor m = {};
  m.joint = joint;
  m.coordinate = coordinate;
  m.kind = kind;
  m.target = target;
  m.limit = limit;
  m.kp = kp;
  m.kd = kd;
  set_drive(drive, address, user, m.drive, m.user);
  set_drive(vary, vary_address, vary_user, m.vary, m.vary_user);
  return demand(nsdae_bodies_add_motor(handle, &m));
}

int bodies::add_sensor(const std::string &name, int kind, int body, int joint, int coordinate,
                       std::array<int, 2> solid, triple point)
{
  nsdae_sensor s = {};
  s.name = name.c_str();
  s.kind = kind;
  s.body = body;
  s.joint = joint;
  s.coordinate = coordinate;
  s.solid[0] = solid[0];
  s.solid[1] = solid[1];
  fill(s.point, point);
  return demand(nsdae_bodies_add_sensor(handle, &s));
}

int bodies::add_joint_spring(int joint, int coordinate, double stiffness, double damping,
                             double rest)
{
  nsdae_joint_spring s = {};
  s.joint = joint;
  s.coordinate = coordinate;
  s.stiffness = stiffness;
  s.damping = damping;
  s.rest = rest;
  return demand(nsdae_bodies_add_joint_spring(handle, &s));
}

int bodies::add_spring(int body0, int body1, triple point, triple end, double stiffness,
                       double damping, double rest)
{
  nsdae_spring s = {};
  s.body[0] = body0;
  s.body[1] = body1;
  s.stiffness = stiffness;
  s.damping = damping;
  s.rest = rest;
  fill(s.point, point);
  fill(s.end, end);
  return demand(nsdae_bodies_add_spring(handle, &s));
}

int bodies::add_torsion(int body0, int body1, triple axis, double stiffness, double damping,
                        double rest)
{
  nsdae_torsion s = {};
  s.body[0] = body0;
  s.body[1] = body1;
  s.stiffness = stiffness;
  s.damping = damping;
  s.rest = rest;
  fill(s.axis, axis);
  return demand(nsdae_bodies_add_torsion(handle, &s));
}

int bodies::add_load(int body, triple point, nb::object load, std::uintptr_t address,
                     std::uintptr_t user)
{
  if (load.is_none())
    return demand(nsdae_bodies_add_load(handle, body, point.data(),
                                        reinterpret_cast<nsdae_load_fn>(address),
                                        reinterpret_cast<void *>(user)));
  const slot in = {3, 0, false}, out = {3, 0, true};
  functions.emplace_back().set_function(load.ptr(), {in, in, out, out}, false);
  return demand(
      nsdae_bodies_add_load(handle, body, point.data(), load_in_python, &functions.back()));
}

int bodies::add_solid(int body, nb::dict d)
{
  vector points;
  const nsdae_solid s = solid_of(d, points);
  return demand(nsdae_bodies_add_solid(handle, body, &s));
}

int bodies::add_contact(int solid0, int solid1, double mu, double e_n, double e_t)
{
  return demand(nsdae_bodies_add_contact(handle, solid0, solid1, mu, e_n, e_t));
}

void bodies::set_pair(int material0, int material1, double mu, double e_n, double e_t)
{
  demand(nsdae_bodies_set_pair(handle, material0, material1, mu, e_n, e_t));
  listed = true;
}

void bodies::set_gravity(triple g)
{
  demand(nsdae_bodies_set_gravity(handle, g.data()));
}

// Reads a scene and adds it; its settings, and shape, radius and length of each solid.
void bodies::set_name(int kind, int i, const std::string &name)
{
  demand(nsdae_bodies_set_name(handle, kind, i, text(name, "name")));
}

void bodies::set_colour(int kind, int i, const std::string &colour)
{
  demand(nsdae_bodies_set_colour(handle, kind, i, text(colour, "colour")));
}

int bodies::material(const std::string &name)
{
  return demand(nsdae_bodies_material(handle, text(name, "material")));
}

void bodies::set_user_rows(std::array<int, 5> sizes, nb::list callbacks)
{
  nsdae_user_rows rows = {};
  rows.dims = {sizes[0], sizes[1], sizes[2], sizes[3], 0, sizes[4]};
  nsdae_dims total;
  demand(nsdae_bodies_get_dims(handle, &total));
  const int planar = dimension == 2, count = total.nq / (planar ? 3 : 7);
  total.nq += sizes[0];
  total.nv += sizes[1];
  total.nt = dimension - 1;
  blocks.nq.assign(static_cast<std::size_t>(count), planar ? 3 : 7);
  blocks.nv.assign(static_cast<std::size_t>(count), planar ? 3 : 6);
  if (sizes[1] > 0) {
    blocks.nq.push_back(sizes[0]);
    blocks.nv.push_back(sizes[1]);
  }
  for (nb::handle one : callbacks) {
    nb::tuple c = nb::cast<nb::tuple>(one);
    const std::string name = nb::cast<std::string>(c[0]);
    set_user_callback(own, name, c[1], nb::cast<std::uintptr_t>(c[2]),
                      nb::cast<std::uintptr_t>(c[3]), total, rows.dims, blocks);
    listed = listed || name == "contacts";
  }
  fill_user_rows(own, rows);
  demand(nsdae_bodies_set_user_rows(handle, &rows));
}

nb::dict bodies::add_scene(const std::string &path)
{
  nsdae_error error;
  nsdae_scene s;
  check(nsdae_scene_read(text(path, "path"), &s, &error), &error);
  const std::unique_ptr<nsdae_scene, void (*)(nsdae_scene *)> held(&s, nsdae_scene_release);
  demand(nsdae_bodies_add_scene(handle, &s));
  listed = true;
  nb::list solids;
  for (int i = 0; i < s.bodies; i++) {
    const nsdae_solid &one = s.solid[i];
    const double *l = one.length, *at = one.position;
    nb::list points;
    for (int j = 0; j < 3 * one.points; j += 3)
      points.append(nb::make_tuple(one.point[j], one.point[j + 1], one.point[j + 2]));
    solids.append(nb::make_tuple(static_cast<int>(one.shape), one.radius, triple{l[0], l[1], l[2]},
                                 triple{at[0], at[1], at[2]}, points, one.material));
  }
  nb::dict d;
  d["wall"] = nb::make_tuple(s.wall[0], s.wall[1]);
  d["floor"] = s.floor;
  d["mu"] = s.mu;
  d["e_n"] = s.e_n;
  d["g"] = s.g;
  d["dt"] = s.dt;
  d["solids"] = solids;
  return d;
}

// Owned by the caller. The garbage collector sees its reference to the bodies, which own the
// functions of drives and loads: one of them may refer to an owner of the system. With the text of
// its warning, or "".
nb::tuple bodies::make_system(nb::object self)
{
  const bodies &b = nb::cast<const bodies &>(self);
  nsdae_system *made = nullptr;
  int status = b.demand(nsdae_bodies_system(b.handle, &made));
  nb::object of = nb::cast(new system(made, b.listed, self), nb::rv_policy::take_ownership);
  return nb::make_tuple(of, readable(status > 0 ? nsdae_bodies_error(b.handle)->text : ""));
}

nb::tuple bodies::start() const
{
  nsdae_dims d;
  demand(nsdae_bodies_get_dims(handle, &d));
  std::vector<double> q(static_cast<std::size_t>(d.nq)), v(static_cast<std::size_t>(d.nv));
  demand(nsdae_bodies_get_start(handle, q.data(), v.data()));
  return nb::make_tuple(array_of(q.data(), q.size()), array_of(v.data(), v.size()));
}

triple bodies::locate(vector q, int body, triple local) const
{
  nsdae_dims d;
  triple point;
  demand(nsdae_bodies_get_dims(handle, &d));
  if (q.shape(0) != static_cast<std::size_t>(d.nq))
    throw std::invalid_argument("q must have the size of the system");
  demand(nsdae_bodies_locate(handle, q.data(), body, local.data(), point.data()));
  return point;
}

namespace
{

int traverse(PyObject *self, visitproc visit, void *arg)
{
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  for (const callback &c : nb::inst_ptr<bodies>(self)->functions) Py_VISIT(c.function);
  for (const callback &c : nb::inst_ptr<bodies>(self)->own) Py_VISIT(c.function);
  return 0;
}

int clear(PyObject *self)
{
  if (nb::inst_ready(self))
    for (callback &c : nb::inst_ptr<bodies>(self)->functions) c.clear();
  if (nb::inst_ready(self))
    for (callback &c : nb::inst_ptr<bodies>(self)->own) c.clear();
  return 0;
}

PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void *>(traverse)},
                       {Py_tp_clear, reinterpret_cast<void *>(clear)},
                       {0, nullptr}};

// (mass, inertia)
nb::tuple solid_inertia(nb::dict d, double density)
{
  vector points;
  const nsdae_solid s = solid_of(d, points);
  double mass, inertia[3];
  nsdae_error error;
  check(nsdae_solid_inertia(&s, density, &mass, inertia, &error), &error);
  return nb::make_tuple(mass, triple{inertia[0], inertia[1], inertia[2]});
}

// (mass, inertia, product, position of the body, positions of the solids)
nb::tuple body_from_solids(nb::list dicts, std::vector<double> density, triple position,
                           double angle, quadruple quaternion)
{
  std::vector<vector> points(dicts.size());
  std::vector<nsdae_solid> solids;
  for (std::size_t i = 0; i < dicts.size(); i++)
    solids.push_back(solid_of(nb::cast<nb::dict>(dicts[i]), points[i]));
  nsdae_rigid_body body = {};
  fill(body.position, position);
  fill(body.quaternion, quaternion);
  body.angle = angle;
  nsdae_error error;
  check(nsdae_body_from_solids(static_cast<int>(solids.size()), solids.data(), density.data(),
                               &body, &error),
        &error);
  nb::list places;
  for (const nsdae_solid &s : solids)
    places.append(triple{s.position[0], s.position[1], s.position[2]});
  const double *J = body.inertia, *P = body.product, *x = body.position;
  return nb::make_tuple(body.mass, triple{J[0], J[1], J[2]}, triple{P[0], P[1], P[2]},
                        triple{x[0], x[1], x[2]}, places);
}

// Points [n, 3] and triangles [n, 3] of a mesh file.
nb::tuple solid_read(const std::string &path, double scale)
{
  nsdae_error error;
  nsdae_solid s;
  check(nsdae_solid_read(text(path, "path"), scale, &s, &error), &error);
  const std::unique_ptr<nsdae_solid, void (*)(nsdae_solid *)> held(&s, nsdae_solid_release);
  const std::size_t points = static_cast<std::size_t>(s.points);
  const std::size_t triangles = static_cast<std::size_t>(s.triangles);
  std::vector<double> point(s.point, s.point + 3 * points);
  std::vector<int> triangle(s.triangle, s.triangle + 3 * triangles);
  return nb::make_tuple(array_of(point, {points, 3}), array_of(triangle, {triangles, 3}));
}

// Coordinates of the corners of its triangles, one after another.
std::vector<double> solid_triangles(nb::dict d)
{
  vector points;
  const nsdae_solid s = solid_of(d, points);
  const std::size_t faces = s.shape == NSDAE_SHAPE_MESH ? static_cast<std::size_t>(s.triangles)
                            : s.shape == NSDAE_SHAPE_HEIGHT_FIELD
                                ? 2 * static_cast<std::size_t>(points.shape(0))
                                : 2 * static_cast<std::size_t>(s.points);
  std::vector<double> made(9 * faces + 1);
  nsdae_error error;
  const int count = nsdae_solid_triangles(&s, made.data(), &error);
  check(count, &error);
  made.resize(9 * static_cast<std::size_t>(count));
  return made;
}

} // namespace

void bind_bodies(nb::module_ &m)
{
  nb::class_<bodies>(m, "Bodies", nb::type_slots(slots))
      .def(nb::init<int>())
      .def("add", &bodies::add)
      .def("add_joint", &bodies::add_joint, nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(),
           nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg().none(),
           nb::arg(), nb::arg())
      .def("add_limit", &bodies::add_limit)
      .def("add_rope", &bodies::add_rope)
      .def("add_coupler", &bodies::add_coupler)
      .def("add_motor", &bodies::add_motor, nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(),
           nb::arg(), nb::arg(), nb::arg().none(), nb::arg(), nb::arg(), nb::arg().none(),
           nb::arg(), nb::arg())
      .def("add_sensor", &bodies::add_sensor)
      .def("add_joint_spring", &bodies::add_joint_spring)
      .def("add_spring", &bodies::add_spring)
      .def("add_torsion", &bodies::add_torsion)
      .def("add_load", &bodies::add_load, nb::arg(), nb::arg(), nb::arg().none(), nb::arg(),
           nb::arg())
      .def("add_solid", &bodies::add_solid)
      .def("add_contact", &bodies::add_contact)
      .def("set_pair", &bodies::set_pair)
      .def("set_gravity", &bodies::set_gravity)
      .def("set_user_rows", &bodies::set_user_rows)
      .def("set_name", &bodies::set_name)
      .def("set_colour", &bodies::set_colour)
      .def("material", &bodies::material)
      .def("add_scene", &bodies::add_scene)
      .def("system", &bodies::make_system)
      .def("start", &bodies::start)
      .def("locate", &bodies::locate);
  m.def("solid_read", &solid_read);
  m.def("solid_inertia", &solid_inertia);
  m.def("body_from_solids", &body_from_solids);
  m.def("solid_triangles", &solid_triangles);
}

} // namespace nsdae_python
