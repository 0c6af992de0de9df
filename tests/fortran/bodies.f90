! A load and a drive in Fortran, for the test below.
module bodies_callbacks
  use, intrinsic :: iso_c_binding
  implicit none

contains

  integer(c_int) function turning(t, drive, user) bind(C)
    real(c_double), value :: t
    real(c_double), intent(inout) :: drive(3)
    type(c_ptr), value :: user
    drive = [3 * t, 3d0, 0d0]
    turning = 0
  end function

  integer(c_int) function carrying(t, position, velocity, force, torque, user) bind(C)
    real(c_double), value :: t
    real(c_double), intent(in) :: position(3), velocity(3)
    real(c_double), intent(inout) :: force(3), torque(3)
    type(c_ptr), value :: user
    real(c_double), pointer :: weight
    call c_f_pointer(user, weight)
    force(2) = weight
    carrying = 0
  end function

  ! A drum of one's own with the rope that carries body 0: rows over all velocities.
  integer(c_int) function drum_mass(t, q, M, ldm, user) bind(C)
    real(c_double), value :: t
    real(c_double), intent(in) :: q(*)
    integer(c_int), value :: ldm
    real(c_double), intent(inout) :: M(ldm, *)
    type(c_ptr), value :: user
    M(1, 1) = 0.5d0
    drum_mass = 0
  end function

  integer(c_int) function rope(t, q, phi, user) bind(C)
    real(c_double), value :: t
    real(c_double), intent(in) :: q(*)
    real(c_double), intent(inout) :: phi(*)
    type(c_ptr), value :: user
    phi(1) = q(2) + q(4)
    rope = 0
  end function

  integer(c_int) function rope_jacobian(t, q, J, ldj, user) bind(C)
    real(c_double), value :: t
    real(c_double), intent(in) :: q(*)
    integer(c_int), value :: ldj
    real(c_double), intent(inout) :: J(ldj, *)
    type(c_ptr), value :: user
    J(1, 2) = 1
    J(1, 4) = 1
    rope_jacobian = 0
  end function

end module

! The kit from Fortran: a driven crank turns as it is told, a carried body stays, a box rests on the
! floor, and what is refused is said.
program mechanism
  use nsdae
  use bodies_callbacks
  use check
  implicit none

  call driven_crank
  call carried_body
  call box_of_halves
  call surfaces
  call mesh_of_a_file
  call box_on_floor
  call spring_and_torsion
  call limits_and_couplers
  call discs_by_material
  call neighbours(0_c_int)
  call neighbours(1_c_int)
  call groups
  call rope_on_drum
  call names
  call lifetimes
  call refused
  call scene_of_a_file
  call check_done

contains

  ! A name is in a message; materials by name.
  subroutine names()
    type(nsdae_bodies) :: bodies
    type(nsdae_error) :: error
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    call is_int(nsdae_bodies_add(bodies, nsdae_rigid_body(mass=1d0, inertia=[0d0, 0d0, 1d0])), 0_c_int, 'body')
    call is_int(nsdae_bodies_set_name(bodies, NSDAE_NAMED_BODY, 0_c_int, 'crank '), NSDAE_OK, 'name')
    call is_int(nsdae_bodies_set_colour(bodies, NSDAE_NAMED_BODY, 0_c_int, '#c23b22'), NSDAE_OK, 'colour')
    call is_int(nsdae_bodies_material(bodies, 'ice'), 63_c_int, 'ice')
    call is_int(nsdae_bodies_material(bodies, 'steel'), 62_c_int, 'steel')
    call is_int(nsdae_bodies_material(bodies, 'ice'), 63_c_int, 'ice again')
    call is_int(nsdae_bodies_set_name(bodies, NSDAE_NAMED_BODY, 0_c_int, 'rod'), NSDAE_E_STATE, 'twice')
    error = nsdae_bodies_error(bodies)
    call is_true(index(error%text, 'crank') > 0, 'the name it has')
    call nsdae_bodies_destroy(bodies)
  end subroutine

  ! The natural order of a builder: its model and system are gone before the run. Free fall is exact
  ! by the default method: z = 1 - g/2 after 1 s.
  subroutine lifetimes()
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    call build(sim)
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'run without its builder')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_near(record%q(3), -3.905d0, 1d-11, 'fall')
    call nsdae_sim_destroy(sim)
  end subroutine

  subroutine build(sim)
    type(nsdae_sim), intent(inout) :: sim
    type(nsdae_bodies) :: bodies
    type(nsdae_system) :: system
    call is_int(nsdae_bodies_create(3_c_int, bodies), NSDAE_OK, 'create')
    call is_int(nsdae_bodies_set_gravity(bodies, [0d0, 0d0, -9.81d0]), NSDAE_OK, 'gravity')
    call is_int(nsdae_bodies_add(bodies, nsdae_rigid_body(mass=1d0, inertia=[1d0, 1d0, 1d0], &
        position=[0d0, 0d0, 1d0])), 0_c_int, 'body')
    call start(bodies, system, sim)
    call nsdae_bodies_destroy(bodies)
    call nsdae_system_destroy(system)
  end subroutine

  subroutine start(bodies, system, sim)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_system), intent(inout) :: system
    type(nsdae_sim), intent(inout) :: sim
    real(c_double) :: q(7), v(6)
    type(nsdae_dims) :: dims
    call is_true(nsdae_bodies_system(bodies, system) >= 0, 'system')
    call is_int(nsdae_bodies_get_dims(bodies, dims), NSDAE_OK, 'dims')
    call is_int(nsdae_bodies_get_start(bodies, q, v), NSDAE_OK, 'start')
    call is_int(nsdae_sim_create(system, sim), NSDAE_OK, 'sim')
    call is_int(nsdae_sim_init(sim, 0d0, q(:dims%nq), v(:dims%nv)), NSDAE_OK, 'init')
  end subroutine

  ! A scene is read, changed and made a mechanism.
  subroutine scene_of_a_file()
    type(nsdae_scene) :: scene
    type(nsdae_bodies) :: bodies
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    type(nsdae_dims) :: dims
    type(nsdae_rigid_body), pointer :: body(:)
    real(c_double) :: q(7 * 64), v(6 * 64)
    character(len=512) :: folder
    call is_int(nsdae_scene_read('/no/such/file.csv', scene, error), NSDAE_E_IO, 'no file')
    call is_true(index(error%text, '/no/such/file.csv') > 0, 'it is named')
    call get_command_argument(1, folder)
    call is_int(nsdae_scene_read(trim(folder)//'/scene_mixed.csv', scene), NSDAE_OK, 'scene')
    call is_int(scene%bodies, 64_c_int, 'its bodies')
    call is_true(scene%dt == 0.002d0 .and. scene%wall(1) == -scene%wall(2), 'its settings')
    call c_f_pointer(scene%body, body, [scene%bodies])
    body(1)%velocity(1) = 1
    call is_int(nsdae_bodies_create(3_c_int, bodies), NSDAE_OK, 'create')
    call is_int(nsdae_bodies_add_scene(bodies, scene), NSDAE_OK, 'add')
    call is_int(nsdae_bodies_system(bodies, system), NSDAE_OK, 'system')
    call is_int(nsdae_bodies_get_dims(bodies, dims), NSDAE_OK, 'dims')
    call is_int(dims%nv, 6_c_int * 64_c_int, 'velocities')
    call is_int(nsdae_bodies_get_start(bodies, q(:7), v, error), NSDAE_E_ARGUMENT, 'too short')
    call is_true(error%text == 'q has 7 entries and v has 384: they need at least 448 and 384', 'the sizes')
    call is_true(error%argument == 'q', 'the short one')
    call is_int(nsdae_bodies_get_start(bodies, q, v), NSDAE_OK, 'start')
    call is_true(v(1) == 1, 'the changed velocity')
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
    call nsdae_scene_release(scene)
    call is_int(scene%bodies, 0_c_int, 'released')
  end subroutine

  subroutine driven_crank()
    type(nsdae_bodies) :: bodies
    type(nsdae_rigid_body) :: crank
    type(nsdae_joint) :: pin
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    real(c_double) :: tip(3)
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    crank%mass = 1
    crank%inertia(3) = 1
    crank%position(1) = 1
    crank%velocity(2) = 3
    crank%spin(3) = 3
    pin%body(2) = nsdae_bodies_add(bodies, crank)
    pin%drive = c_funloc(turning)
    call is_int(nsdae_bodies_add_joint(bodies, pin), 0_c_int, 'joint')
    call start(bodies, system, sim)
    call is_int(nsdae_sim_run(sim, 0.5d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(abs(record%q(3) - 1.5d0) < 1d-6, 'the crank turns as it is told')
    call is_int(nsdae_bodies_locate(bodies, record%q, 0_c_int, [1d0, 0d0, 0d0], tip), NSDAE_OK, &
                'locate')
    call is_true(abs(tip(1) - 2 * cos(1.5d0)) < 1d-3, 'its tip is where it points')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
  end subroutine

  subroutine carried_body()
    type(nsdae_bodies) :: bodies
    type(nsdae_rigid_body) :: body
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    real(c_double), target :: weight = 20
    call is_int(nsdae_bodies_create(3_c_int, bodies), NSDAE_OK, 'create')
    body%mass = 2
    body%inertia = 1
    call is_int(nsdae_bodies_set_gravity(bodies, [0d0, -10d0, 0d0]), NSDAE_OK, 'gravity')
    call is_int(nsdae_bodies_add(bodies, body), 0_c_int, 'body')
    call is_int(nsdae_bodies_add_load(bodies, 0_c_int, [0d0, 0d0, 0d0], carrying, c_loc(weight)), &
                0_c_int, 'load')
    call start(bodies, system, sim)
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(all(abs(record%v) < 1d-14), 'what is carried stays')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
  end subroutine

  ! Two cubes side by side, one of them as the hull of its corners, are a box.
  subroutine box_of_halves()
    type(nsdae_rigid_body) :: body
    type(nsdae_solid) :: half(2)
    type(nsdae_error) :: error
    real(c_double) :: triangle(3, 3, 12)
    integer :: i, j
    half(1)%shape = NSDAE_SHAPE_BOX
    half(1)%length = 1
    half(2)%shape = NSDAE_SHAPE_POLYHEDRON
    half(2)%point = reshape([((0.5d0 - ibits(i, j, 1), j = 0, 2), i = 0, 7)], [3, 8])
    half(2)%position(1) = 1
    call is_int(nsdae_solid_triangles(half(2), triangle), 12, 'triangles of a cube')
    call is_true(all(abs(abs(triangle) - 0.5d0) < 1d-14), 'its corners')
    call is_int(nsdae_body_from_solids(half, [3d0, 3d0], body), NSDAE_OK, 'halves')
    call is_true(abs(body%mass - 6) < 1d-14 .and. abs(body%inertia(1) - 1) < 1d-14 .and. &
                 abs(body%inertia(2) - 2.5d0) < 1d-14 .and. abs(body%position(1) - 0.5d0) < 1d-14 .and. &
                 abs(half(1)%position(1) + 0.5d0) < 1d-14, 'a box of two cubes')
    call is_int(nsdae_body_from_solids(half, [3d0, -3d0], body, error), NSDAE_E_ARGUMENT, 'a density below 0')
    call is_true(error%argument == 'density', 'named')
  end subroutine

  ! The surface of a field of four heights is two triangles; a mesh of them is open.
  subroutine surfaces()
    type(nsdae_solid) :: field, mesh(1)
    type(nsdae_rigid_body) :: body
    type(nsdae_error) :: error
    real(c_double) :: triangle(3, 3, 2)
    field%shape = NSDAE_SHAPE_HEIGHT_FIELD
    field%length = [2d0, 4d0, 1d0]
    field%point = reshape([1d0, 2d0, 3d0, 4d0], [2, 2])
    call is_int(nsdae_solid_triangles(field, triangle), 2, 'triangles of a cell')
    call is_true(all(abs(triangle(:, 2, 1) - [1d0, -2d0, 2d0]) < 1d-14), 'its corner of largest x')
    mesh(1)%shape = NSDAE_SHAPE_MESH
    mesh(1)%length(3) = 1
    mesh(1)%point = reshape(triangle, [3, 6])
    mesh(1)%triangle = reshape([0, 1, 2, 3, 4, 5], [3, 2])
    call is_int(nsdae_solid_triangles(mesh(1), triangle), 2, 'triangles of a mesh')
    call is_int(nsdae_body_from_solids(mesh, [1d0], body, error), NSDAE_E_ARGUMENT, 'an open surface')
    call is_true(error%argument == 'triangle', 'its side')
  end subroutine

  ! Two triangles of a file, in millimetres.
  subroutine mesh_of_a_file()
    type(nsdae_solid) :: mesh
    type(nsdae_error) :: error
    type(nsdae_bodies) :: bodies
    integer :: unit
    open (newunit=unit, file='bodies_f90.obj', action='write')
    write (unit, '(a)') 'v 0 0 0', 'v 1000 0 0', 'v 0 1000 0', 'v 1000 1000 0', 'f 1 2 4 3'
    close (unit)
    call is_int(nsdae_solid_read('/no/such/file.stl', 1d0, mesh, error), NSDAE_E_IO, 'no file')
    call is_true(index(error%text, '/no/such/file.stl') > 0, 'it is named')
    call is_int(nsdae_solid_read('bodies_f90.obj', 1d-3, mesh), NSDAE_OK, 'mesh')
    call is_true(all(shape(mesh%point) == [3, 4]) .and. all(mesh%triangle(:, 2) == [0, 3, 2]), 'its sizes')
    call is_true(all(mesh%point(:, 4) == [1d0, 1d0, 0d0]), 'its points')
    mesh%length(3) = 1
    call is_int(nsdae_bodies_create(3_c_int, bodies), NSDAE_OK, 'create')
    call is_int(nsdae_bodies_add_solid(bodies, NSDAE_GROUND, mesh), 0_c_int, 'the ground')
    call nsdae_bodies_destroy(bodies)
  end subroutine

  subroutine box_on_floor()
    type(nsdae_bodies) :: bodies
    type(nsdae_rigid_body) :: body
    type(nsdae_solid) :: floor, box
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    integer(c_int) :: first, second
    real(c_double), allocatable :: point(:, :), force(:, :)
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    box%shape = NSDAE_SHAPE_POLYGON
    box%point = reshape([-0.5d0, -0.5d0, 0.5d0, -0.5d0, 0.5d0, 0.5d0, -0.5d0, 0.5d0], [2, 4])
    call is_int(nsdae_solid_inertia(box, 3d0, body%mass, body%inertia), NSDAE_OK, 'inertia')
    call is_true(abs(body%mass - 3) < 1d-15 .and. abs(body%inertia(3) - 0.5d0) < 1d-15, 'of a square')
    body%position(2) = 0.5d0
    floor%shape = NSDAE_SHAPE_PLANE
    call is_int(nsdae_bodies_set_gravity(bodies, [0d0, -10d0, 0d0]), NSDAE_OK, 'gravity')
    call is_int(nsdae_bodies_add(bodies, body), 0_c_int, 'body')
    first = nsdae_bodies_add_solid(bodies, NSDAE_GROUND, floor)
    second = nsdae_bodies_add_solid(bodies, 0_c_int, box)
    call is_int(nsdae_bodies_add_contact(bodies, first, second, 0.5d0, 0d0, 0d0), 0_c_int, 'contact')
    call start(bodies, system, sim)
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(all(record%v == 0), 'a box at rest has no velocity at all')
    call is_int(nsdae_sim_get_contact_forces(sim, point, force), NSDAE_OK, 'contact forces')
    call is_true(size(point, 2) == record%contacts%count, 'points of all contacts')
    call is_true(abs(sum(force(2, :)) - 30) < 1d-9, 'the weight')
    call is_true(any(abs(point(1, :) - 0.5d0) < 1d-9), 'at a corner')
    call nsdae_sim_destroy(sim)
    call is_int(nsdae_sim_get_contact_forces(sim, point, force), NSDAE_E_ARGUMENT, 'of no simulation')
    call is_true(.not. allocated(point) .and. .not. allocated(force), 'no contact forces')
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
  end subroutine

  ! A rack of 2 kg on a pinion of 1 kg m^2 and radius 0.5 m with a damper, up to its stop; a rope.
  subroutine limits_and_couplers()
    type(nsdae_bodies) :: bodies
    type(nsdae_rigid_body) :: body
    type(nsdae_joint) :: joint
    type(nsdae_limit) :: limit
    type(nsdae_rope) :: rope
    type(nsdae_coupler) :: coupler
    type(nsdae_joint_spring) :: damper
    type(nsdae_motor) :: motor
    real(c_double) :: is, values(NSDAE_VALUES_MAX)
    type(nsdae_sensor) :: sensor
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    call is_int(nsdae_bodies_set_gravity(bodies, [6d0, 0d0, 0d0]), NSDAE_OK, 'gravity')
    body%mass = 2
    body%inertia(3) = 1
    call is_int(nsdae_bodies_add(bodies, body), 0_c_int, 'pinion')
    call is_int(nsdae_bodies_add(bodies, body), 1_c_int, 'rack')
    joint%body(2) = 0
    call is_int(nsdae_bodies_add_joint(bodies, joint), 0_c_int, 'hinge')
    joint%kind = NSDAE_JOINT_PRISMATIC
    joint%body(2) = 1
    joint%axis(1) = 1
    call is_int(nsdae_bodies_add_joint(bodies, joint), 1_c_int, 'rail')
    coupler%joint = [0_c_int, 1_c_int]
    coupler%p(2) = 0.5d0
    call is_int(nsdae_bodies_add_coupler(bodies, coupler), 0_c_int, 'coupler')
    limit%joint = 1
    limit%low = -1
    limit%high = 0.9d0
    call is_int(nsdae_bodies_add_limit(bodies, limit), 0_c_int, 'limit')
    rope%body(2) = 1
    rope%length = 3
    call is_int(nsdae_bodies_add_rope(bodies, rope), 2_c_int, 'rope')
    call is_int(nsdae_bodies_add_joint_spring(bodies, damper), 0_c_int, 'damper')
    motor%joint = 1
    motor%target = 12
    motor%limit = 12
    call is_int(nsdae_bodies_add_motor(bodies, motor), 0_c_int, 'motor')
    motor%kind = NSDAE_MOTOR_SPEED
    motor%target = 0
    call is_int(nsdae_bodies_add_motor(bodies, motor), 1_c_int, 'dry friction')
    sensor%joint = 1
    call is_int(nsdae_bodies_add_sensor(bodies, sensor, 'rack '), 0_c_int, 'sensor')
    sensor%kind = NSDAE_SENSOR_VELOCITY
    sensor%body = 1
    call is_int(nsdae_bodies_add_sensor(bodies, sensor), 1_c_int, 'sensor')
    call start(bodies, system, sim)
    call is_int(nsdae_system_sensor_size(system, 1_c_int), 2_c_int, 'size')
    call is_int(nsdae_system_sensor_size(system, 2_c_int), 0_c_int, 'no such sensor')
    call is_true(nsdae_system_get_name(system, NSDAE_NAME_SENSOR, 0_c_int) == 'rack', 'name')
    call is_int(nsdae_sim_run(sim, 0.5d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_int(nsdae_sim_get_sensor(sim, 0_c_int, values), NSDAE_OK, 'sensor')
    call is_true(abs(values(1) - record%q(4)) < 1d-14, 'coordinate')
    call is_int(nsdae_sim_get_sensor(sim, 1_c_int, values), NSDAE_OK, 'sensor')
    call is_true(values(1) == record%v(4) .and. values(2) == record%v(5), 'velocity')
    call is_int(nsdae_sim_get_sensor(sim, 2_c_int, values), NSDAE_E_ARGUMENT, 'no such sensor')
    call is_true(abs(record%q(4) - 0.25d0) < 1d-2, 'half of 2 g / (2 + 1 / 0.25) t^2')
    call is_true(abs(record%q(4) - 0.5d0 * record%q(3)) < 1d-5, 'the rack follows')
    call is_int(nsdae_sim_run(sim, 2d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(abs(record%q(4) - 0.9d0) < 1d-2, 'the rack is at its stop')
    call is_int(nsdae_sim_set_control(sim, 0_c_int, -12d0), NSDAE_OK, 'against the gravity')
    call is_int(nsdae_sim_get_control(sim, 0_c_int, is), NSDAE_OK, 'control')
    call is_true(is == -12, 'control')
    call is_int(nsdae_sim_set_control(sim, 1_c_int, -1d0), NSDAE_OK, 'back')
    call is_int(nsdae_sim_run(sim, 2.5d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(record%q(4) < 0.85d0, 'the rack leaves its stop')
    call is_int(nsdae_sim_set_control(sim, 2_c_int, 0d0), NSDAE_E_ARGUMENT, 'no such motor')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
  end subroutine

  ! 2 kg on a spring of 18 N/m, 0.1 m too long, that turns against 4 N m/rad with its zero at 0.2.
  subroutine spring_and_torsion()
    type(nsdae_bodies) :: bodies
    type(nsdae_rigid_body) :: body
    type(nsdae_spring) :: spring
    type(nsdae_torsion) :: torsion
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    body%mass = 2
    body%inertia = 1
    body%position(1) = 1.1d0
    call is_int(nsdae_bodies_add(bodies, body), 0_c_int, 'body')
    spring%body(2) = 0
    spring%end(1) = 1.1d0
    spring%stiffness = 18
    spring%rest = 1
    call is_int(nsdae_bodies_add_spring(bodies, spring), 0_c_int, 'spring')
    torsion%body(2) = 0
    torsion%stiffness = 4
    torsion%rest = 0.2d0
    call is_int(nsdae_bodies_add_torsion(bodies, torsion), 0_c_int, 'torsion')
    call start(bodies, system, sim)
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(abs(record%q(1) - 1 - 0.1d0 * cos(3d0)) < 1d-5, 'the spring swings')
    call is_true(abs(record%q(3) - 0.2d0 * (1 - cos(2d0))) < 1d-5, 'and turns')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
  end subroutine

  ! Two discs, one on the other on a floor, found by their materials: what carries them is their weight.
  subroutine discs_by_material()
    type(nsdae_bodies) :: bodies
    type(nsdae_rigid_body) :: body
    type(nsdae_solid) :: floor, disc
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    integer(c_int) :: i
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    call is_int(nsdae_bodies_set_gravity(bodies, [0d0, -10d0, 0d0]), NSDAE_OK, 'gravity')
    floor%shape = NSDAE_SHAPE_PLANE
    call is_int(nsdae_bodies_add_solid(bodies, NSDAE_GROUND, floor), 0_c_int, 'floor')
    disc%shape = NSDAE_SHAPE_DISC
    disc%radius = 0.5d0
    disc%material = 1
    body%mass = 1
    body%inertia = 0.125d0
    do i = 0, 1
      body%position(2) = 0.5d0 + i
      call is_int(nsdae_bodies_add(bodies, body), i, 'body')
      call is_int(nsdae_bodies_add_solid(bodies, i, disc), i + 1_c_int, 'disc')
    end do
    call is_int(nsdae_bodies_set_pair(bodies, 0_c_int, 1_c_int, 0.5d0, 0d0, 0d0), NSDAE_OK, 'on the floor')
    call is_int(nsdae_bodies_set_pair(bodies, 1_c_int, 1_c_int, 0.5d0, 0d0, 0d0), NSDAE_OK, 'on a disc')
    call start(bodies, system, sim)
    call is_int(nsdae_sim_run(sim, 0.1d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(all(abs(record%v) < 1d-14), 'both rest')
    call is_int(nsdae_bodies_set_pair(bodies, 0_c_int, 1_c_int, 0d0, 0d0, 0d0), NSDAE_E_STATE, 'too late')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
  end subroutine

  ! Two discs that move towards each other, and after 1 s the velocity of the first.
  subroutine meeting_discs(bodies, group, exclude)
    type(nsdae_bodies), intent(inout) :: bodies
    integer(c_int), intent(in) :: group, exclude
    type(nsdae_rigid_body) :: body
    type(nsdae_solid) :: disc
    integer(c_int) :: i
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    disc%shape = NSDAE_SHAPE_DISC
    disc%radius = 0.25d0
    body%mass = 1
    body%inertia = 1
    do i = 0, 1
      body%position(1) = i - 0.5d0
      body%velocity(1) = 1 - 2 * i
      if (i == 0) disc%group = group
      if (i == 1) disc%exclude = exclude
      call is_int(nsdae_bodies_add(bodies, body), i, 'body')
      call is_int(nsdae_bodies_add_solid(bodies, i, disc), i, 'disc')
    end do
    call is_int(nsdae_bodies_set_pair(bodies, 0_c_int, 0_c_int, 0d0, 0d0, 0d0), NSDAE_OK, 'pair')
  end subroutine

  subroutine met(bodies, velocity, what)
    type(nsdae_bodies), intent(inout) :: bodies
    real(c_double), intent(in) :: velocity
    character(*), intent(in) :: what
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    call start(bodies, system, sim)
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(abs(record%v(1) - velocity) < 1d-12, what)
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
  end subroutine

  subroutine neighbours(collide)
    integer(c_int), intent(in) :: collide
    type(nsdae_bodies) :: bodies
    type(nsdae_joint) :: guide
    call meeting_discs(bodies, 0_c_int, 0_c_int)
    guide%kind = NSDAE_JOINT_PRISMATIC
    guide%body = [0, 1]
    guide%axis(1) = 1
    guide%collide_connected = collide
    call is_int(nsdae_bodies_add_joint(bodies, guide), 0_c_int, 'joint')
    call met(bodies, 1d0 - collide, 'bodies of a joint touch if it lets them')
  end subroutine

  subroutine groups()
    type(nsdae_bodies) :: bodies
    call meeting_discs(bodies, 5_c_int, 4_c_int)
    call met(bodies, 1d0, 'a solid does not touch a group that it excludes')
    call meeting_discs(bodies, 5_c_int, 2_c_int)
    call met(bodies, 0d0, 'a solid touches other groups')
  end subroutine

  ! 2 kg on a drum of 0.5 kg m^2 and 1 m fall with 2 g / 2.5.
  subroutine rope_on_drum()
    type(nsdae_bodies) :: bodies
    type(nsdae_rigid_body) :: body
    type(nsdae_user_rows) :: drum
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    body%mass = 2
    body%inertia = 1
    call is_int(nsdae_bodies_set_gravity(bodies, [0d0, -10d0, 0d0]), NSDAE_OK, 'gravity')
    call is_int(nsdae_bodies_add(bodies, body), 0_c_int, 'body')
    drum%dims = nsdae_dims(nq=1, nv=1, m=1, k=0, nt=0, f=0)
    drum%mass = c_funloc(drum_mass)
    drum%constraint = c_funloc(rope)
    drum%constraint_jacobian = c_funloc(rope_jacobian)
    call is_int(nsdae_bodies_set_user_rows(bodies, drum), NSDAE_OK, 'own')
    call start(bodies, system, sim)
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(abs(record%q(2) + 4) < 1d-9 .and. abs(record%q(4) - 4) < 1d-9, 'both fall and turn')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
    call nsdae_bodies_destroy(bodies)
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    drum%mass = c_null_funptr
    call is_int(nsdae_bodies_set_user_rows(bodies, drum), NSDAE_E_ARGUMENT, 'no mass')
    call nsdae_bodies_destroy(bodies)
  end subroutine

  subroutine refused()
    type(nsdae_bodies) :: bodies
    type(nsdae_rigid_body) :: body
    type(nsdae_spring) :: spring
    type(nsdae_torsion) :: torsion
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    call is_int(nsdae_bodies_create(4_c_int, bodies, error), NSDAE_E_ARGUMENT, 'dimension')
    call is_text(trim(error%argument), 'dimension', 'argument')
    call is_int(nsdae_bodies_create(2_c_int, bodies), NSDAE_OK, 'create')
    body%mass = 1
    body%inertia = 1
    call is_int(nsdae_bodies_add(bodies, body), 0_c_int, 'body')
    spring%body(2) = 0
    torsion%body(2) = 0
    call is_int(nsdae_bodies_add_torsion(bodies, torsion), 0_c_int, 'torsion')
    spring%stiffness = -1
    call is_int(nsdae_bodies_add_spring(bodies, spring), NSDAE_E_ARGUMENT, 'stiffness')
    call is_int(nsdae_bodies_system(bodies, system, error), NSDAE_E_ARGUMENT, 'the first failure')
    call is_text(trim(error%argument), 'stiffness', 'argument')
    error = nsdae_bodies_error(bodies)
    call is_int(error%status, NSDAE_E_ARGUMENT, 'status')
    call nsdae_bodies_destroy(bodies)
  end subroutine

end program
