! nsdae/bodies.h: rigid bodies, joints, forces and contacts between shapes, as a system.
!
! Bodies have a pose at the start. Joints, springs and contacts are given by points and axes in
! space at that time. Planar: q = [x, y, theta] of each body, v = q'. Spatial: q = [x, y, z,
! quaternion w, x, y, z], v = [x', y', z', angular velocity in body axes]. Bodies, solids, joints
! and contacts are numbered from 0, as in C; NSDAE_GROUND is the ground.
!
! Drives and loads are interoperable procedures (c_funloc) with a user pointer (c_loc).
module nsdae_f_bodies
  use, intrinsic :: iso_c_binding
  use nsdae_f_status
  use nsdae_f_system
  use nsdae_f_text
  use nsdae_f_shape, only: NSDAE_SHAPE_POINT, NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_MESH, NSDAE_SHAPE_HEIGHT_FIELD
  implicit none
  private

  ! Materials are 0 .. NSDAE_MATERIALS - 1.
  ! headers: constants NSDAE_GROUND NSDAE_MATERIALS NSDAE_JOINT_ NSDAE_COUPLER_ NSDAE_MOTOR_ NSDAE_NAMED_
  ! headers: constants NSDAE_SENSOR_

  ! A rigid body at the start.
  type, bind(C), public :: nsdae_rigid_body
    real(c_double) :: mass = 0           ! > 0 [kg]
    real(c_double) :: inertia(3) = 0     ! body axes, > 0 [kg m^2]; planar: the third only
    real(c_double) :: product(3) = 0     ! spatial: entries (1, 2), (1, 3), (2, 3) of the inertia tensor
    real(c_double) :: position(3) = 0    ! of the centre of mass [m]
    real(c_double) :: angle = 0          ! planar [rad]
    real(c_double) :: quaternion(4) = 0  ! spatial: w, x, y, z; all zero: no rotation
    real(c_double) :: velocity(3) = 0    ! of the centre of mass [m/s]
    real(c_double) :: spin(3) = 0        ! body axes [rad/s]; planar: the third only
  end type

  ! A solid of a body; the C header describes each shape in its frame.
  type, public :: nsdae_solid
    integer(c_int) :: shape = NSDAE_SHAPE_POINT
    real(c_double) :: radius = 0
    real(c_double) :: length(3) = 0
    logical :: hollow = .false.                    ! a disc with a hole
    ! [2, corners] of a polygon, anticlockwise; [3, points] of a polyhedron or mesh; [nx, ny] heights of a height field
    real(c_double), allocatable :: point(:, :)
    integer(c_int), allocatable :: triangle(:, :)  ! [3, triangles] of a mesh, numbers of points from 0
    real(c_double) :: position(3) = 0, angle = 0   ! in the body's frame
    real(c_double) :: quaternion(4) = 0
    integer(c_int) :: material = 0                 ! for nsdae_bodies_set_pair
    integer(c_int) :: group = 0, exclude = 0       ! bits: its groups, groups that it does not touch
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_solid

  ! A joint; points and axes are in space at the start.
  type, bind(C), public :: nsdae_joint
    integer(c_int) :: kind = NSDAE_JOINT_REVOLUTE
    integer(c_int) :: body(2) = NSDAE_GROUND
    real(c_double) :: point(3) = 0
    real(c_double) :: end(3) = 0    ! DISTANCE: of the second body
    real(c_double) :: axis(3) = 0
    real(c_double) :: cross(3) = 0  ! UNIVERSAL
    real(c_double) :: ratio = 0     ! GEAR; SCREW: pitch
    type(c_funptr) :: drive = c_null_funptr  ! a nsdae_drive_fn; null: free
    type(c_ptr) :: user = c_null_ptr
    real(c_double) :: mu = 0        ! SLOT, REVOLUTE
    real(c_double) :: radius = 0    ! REVOLUTE: of its pin
    integer(c_int) :: collide_connected = 0  ! not 0: its bodies touch by nsdae_bodies_set_pair
  end type

  ! Ends of a coordinate of a joint, as contacts without friction; an infinite end is free.
  type, bind(C), public :: nsdae_limit
    integer(c_int) :: joint = 0, coordinate = 0
    real(c_double) :: low = 0, high = 0
    real(c_double) :: e_n = 0
  end type

  ! A rope between two points: the contact length - distance >= 0.
  type, bind(C), public :: nsdae_rope
    integer(c_int) :: body(2) = NSDAE_GROUND
    real(c_double) :: point(3) = 0, end(3) = 0
    real(c_double) :: length = 0
    real(c_double) :: e_n = 0
  end type

  ! A spring and damper of a coordinate of a joint.
  type, bind(C), public :: nsdae_joint_spring
    integer(c_int) :: joint = 0, coordinate = 0
    real(c_double) :: stiffness = 0, damping = 0
    real(c_double) :: rest = 0  ! coordinate without force; a rotation in space: -pi .. pi
  end type

  ! Coordinates of two joints: s_1 = p(1) + p(2) s_0 + p(3) s_0**2 + ...
  type, bind(C), public :: nsdae_coupler
    integer(c_int) :: joint(2) = 0, coordinate(2) = 0
    real(c_double) :: p(NSDAE_COUPLER_COEFFICIENTS) = 0
  end type

  ! A motor of a coordinate of a joint.
  type, bind(C), public :: nsdae_motor
    integer(c_int) :: joint = 0, coordinate = 0
    integer(c_int) :: kind = NSDAE_MOTOR_FORCE
    real(c_double) :: target = 0  ! without a drive
    real(c_double) :: limit = 0   ! of its force
    real(c_double) :: kp = 0, kd = 0  ! POSITION
    type(c_funptr) :: drive = c_null_funptr, vary = c_null_funptr  ! nsdae_drive_fn: target, limit
    type(c_ptr) :: user = c_null_ptr, vary_user = c_null_ptr
  end type

  ! A quantity that nsdae_sim_get_sensor reads; name: of characters that end with c_null_char, null:
  ! none.
  type, bind(C), public :: nsdae_sensor
    type(c_ptr) :: name = c_null_ptr  ! the argument name of nsdae_bodies_add_sensor gives it
    integer(c_int) :: kind = NSDAE_SENSOR_COORDINATE
    integer(c_int) :: body = 0
    integer(c_int) :: joint = 0, coordinate = 0
    integer(c_int) :: solid(2) = 0
    real(c_double) :: point(3) = 0  ! of the body, in space at the start
  end type

  ! A spring and damper between two points.
  type, bind(C), public :: nsdae_spring
    integer(c_int) :: body(2) = NSDAE_GROUND
    real(c_double) :: point(3) = 0, end(3) = 0
    real(c_double) :: stiffness = 0, damping = 0
    real(c_double) :: rest = 0  ! free length
  end type

  ! A rotational spring and damper about an axis.
  type, bind(C), public :: nsdae_torsion
    integer(c_int) :: body(2) = NSDAE_GROUND
    real(c_double) :: axis(3) = 0
    real(c_double) :: stiffness = 0, damping = 0
    real(c_double) :: rest = 0  ! angle of zero torque; in space -pi .. pi
  end type

  ! The user's own coordinates, constraints, contacts and frictional joints; the C header describes
  ! their order. Callbacks are interoperable procedures (c_funloc) with the arguments of
  ! nsdae/system.h; arrays have assumed size.
  type, bind(C), public :: nsdae_user_rows
    type(nsdae_dims) :: dims = nsdae_dims(0, 0, 0, 0, 0, 0)  ! of the user rows
    type(c_funptr) :: mass = c_null_funptr
    type(c_funptr) :: force = c_null_funptr
    type(c_funptr) :: constraint = c_null_funptr
    type(c_funptr) :: constraint_jacobian = c_null_funptr
    type(c_funptr) :: constraint_bias = c_null_funptr
    type(c_funptr) :: gap = c_null_funptr
    type(c_funptr) :: gap_normal = c_null_funptr
    type(c_funptr) :: gap_tangent = c_null_funptr
    type(c_funptr) :: contact_bias = c_null_funptr
    type(c_funptr) :: contact_acceleration = c_null_funptr
    type(c_funptr) :: frictional_joint_tangent = c_null_funptr
    type(c_funptr) :: kinematics = c_null_funptr
    type(c_funptr) :: constraint_rows = c_null_funptr
    type(c_funptr) :: contacts = c_null_funptr
    type(c_funptr) :: potential = c_null_funptr
    type(c_ptr) :: user = c_null_ptr
  end type

  ! Bodies in space of one solid each, on a floor and between walls; the C header describes it. Freed
  ! by nsdae_scene_release.
  type, bind(C), public :: nsdae_scene
    integer(c_int) :: bodies = 0
    type(c_ptr) :: body = c_null_ptr   ! nsdae_rigid_body, one for each
    type(c_ptr) :: solid = c_null_ptr  ! nsdae_c_solid, one for each
    real(c_double) :: wall(2) = 0      ! x and y of the walls
    real(c_double) :: floor = 0        ! z
    real(c_double) :: mu = 0, e_n = 0
    real(c_double) :: g = 0            ! along -z
    real(c_double) :: dt = 0
  end type

  ! A mechanism; empty before nsdae_bodies_create. Copies refer to the same mechanism.
  type, public :: nsdae_bodies
    private
    type(c_ptr) :: handle = c_null_ptr
  end type

  abstract interface
    ! drive := f(t), f'(t), f''(t)
    integer(c_int) function nsdae_drive_fn(t, drive, user) bind(C)
      import
      real(c_double), value :: t
      real(c_double), intent(inout) :: drive(3)
      type(c_ptr), value :: user
    end function
    ! Force and torque on a point of this position and velocity; both are zero on entry.
    integer(c_int) function nsdae_load_fn(t, position, velocity, force, torque, user) bind(C)
      import
      real(c_double), value :: t
      real(c_double), intent(in) :: position(3), velocity(3)
      real(c_double), intent(inout) :: force(3), torque(3)
      type(c_ptr), value :: user
    end function
  end interface

  public :: nsdae_drive_fn, nsdae_load_fn
  public :: nsdae_bodies_create, nsdae_bodies_destroy, nsdae_bodies_add, nsdae_bodies_add_joint, &
            nsdae_bodies_add_limit, nsdae_bodies_add_rope, nsdae_bodies_add_coupler, &
            nsdae_bodies_add_joint_spring, nsdae_bodies_add_motor, nsdae_bodies_add_sensor, &
            nsdae_bodies_add_spring, nsdae_bodies_add_torsion, nsdae_bodies_add_load, &
            nsdae_bodies_add_solid, nsdae_bodies_add_contact, nsdae_bodies_set_pair, nsdae_bodies_set_gravity, &
            nsdae_bodies_set_user_rows, nsdae_bodies_system, nsdae_bodies_get_dims, nsdae_bodies_get_start, &
            nsdae_bodies_locate, nsdae_bodies_error, nsdae_solid_inertia, nsdae_body_from_solids, nsdae_solid_triangles, &
            nsdae_solid_read, &
            nsdae_bodies_add_scene, &
            nsdae_scene_read, nsdae_scene_release, nsdae_bodies_set_name, nsdae_bodies_material, &
            nsdae_bodies_set_colour

  interface
    ! headers: functions nsdae_bodies_ create destroy add add_joint add_spring add_torsion add_load add_solid
    ! headers: functions nsdae_bodies_ add_limit add_rope add_coupler add_joint_spring add_motor add_sensor
    ! headers: functions nsdae_bodies_ add_contact set_pair set_gravity set_user_rows system get_dims
    ! headers: functions nsdae_bodies_ get_start locate error
    ! headers: functions nsdae_bodies_ add_scene set_name set_colour material
    ! headers: functions nsdae_solid_ inertia triangles
    ! headers: functions nsdae_body_ from_solids
    ! headers: functions nsdae_scene_ read
    ! headers: functions nsdae_ solid_read solid_release

    subroutine nsdae_scene_release(scene) bind(C)
      import
      type(nsdae_scene), intent(inout) :: scene
    end subroutine
  end interface

contains

  type(c_ptr) function at(bodies) result(handle)
    type(nsdae_bodies), intent(in) :: bodies
    handle = bodies%handle
  end function

  ! An empty world of dimension 2 or 3.
  integer(c_int) function nsdae_bodies_create(dimension, bodies, error) result(status)
    integer(c_int), intent(in) :: dimension
    type(nsdae_bodies), intent(out) :: bodies
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_create(dimension, bodies%handle, why)
    call error_from_c(why, error)
  end function

  ! A system made of the model keeps what it reads: handles can be destroyed in any order.
  subroutine nsdae_bodies_destroy(bodies)
    type(nsdae_bodies), intent(inout) :: bodies
    call c_destroy(bodies%handle)
  end subroutine

  ! Each adds one thing: its number, or a status < 0, which is remembered: later calls return it too,
  ! and so does nsdae_bodies_system, so that it is enough to look there.
  ! headers: wrappers nsdae_bodies_ add add_joint add_spring add_torsion
  ! headers: wrappers nsdae_bodies_ add_limit add_rope add_coupler add_joint_spring add_motor

  ! Adds a sensor, with this name if it is given.
  integer(c_int) function nsdae_bodies_add_sensor(bodies, sensor, name) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_sensor), intent(in) :: sensor
    character(len=*), intent(in), optional :: name
    type(nsdae_sensor) :: given
    character(kind=c_char), allocatable, target :: c_name(:)
    given = sensor
    if (present(name)) then
      allocate (c_name(len_trim(name) + 1))
      call to_chars(name, c_name)
      given%name = c_loc(c_name)
    end if
    number = c_add_sensor(at(bodies), given)
  end function

  ! Adds a force callback on the point of a body, in space at the start.
  integer(c_int) function nsdae_bodies_add_load(bodies, body, point, load, user) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    integer(c_int), intent(in) :: body
    real(c_double), intent(in) :: point(3)
    procedure(nsdae_load_fn) :: load
    type(c_ptr), intent(in), optional :: user
    type(c_ptr) :: given
    given = c_null_ptr
    if (present(user)) given = user
    number = c_add_load(at(bodies), body, point, c_funloc(load), given)
  end function

  integer(c_int) function nsdae_bodies_add_solid(bodies, body, solid) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    integer(c_int), intent(in) :: body
    type(nsdae_solid), intent(in), target :: solid
    number = c_add_solid(at(bodies), body, to_c(solid))
  end function

  ! Lets two solids touch: the number of the first of their contacts, from 0. In a system with a
  ! contact list the numbers are ids of the list.
  ! headers: wrappers nsdae_bodies_ add_contact

  ! Lets every two solids of these materials touch that belong to different bodies without a joint:
  ! the system has a contact list, and there can be many contacts.
  ! headers: wrappers nsdae_bodies_ set_pair

  ! Names a body or a solid (NSDAE_NAMED_BODY, NSDAE_NAMED_SOLID) in messages, pictures and files.
  integer(c_int) function nsdae_bodies_set_name(bodies, kind, i, name) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    integer(c_int), intent(in) :: kind, i
    character(len=*), intent(in) :: name
    character(kind=c_char) :: c_name(len_trim(name) + 1)
    call to_chars(name, c_name)
    status = c_set_name(at(bodies), kind, i, c_name)
  end function

  ! Colour '#rrggbb' of a body or a solid in pictures and files.
  integer(c_int) function nsdae_bodies_set_colour(bodies, kind, i, colour) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    integer(c_int), intent(in) :: kind, i
    character(len=*), intent(in) :: colour
    character(kind=c_char) :: c_colour(len_trim(colour) + 1)
    call to_chars(colour, c_colour)
    status = c_set_colour(at(bodies), kind, i, c_colour)
  end function

  ! Number of the material of this name.
  integer(c_int) function nsdae_bodies_material(bodies, name) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    character(len=*), intent(in) :: name
    character(kind=c_char) :: c_name(len_trim(name) + 1)
    call to_chars(name, c_name)
    number = c_material(at(bodies), c_name)
  end function

  integer(c_int) function nsdae_bodies_set_gravity(bodies, gravity) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    real(c_double), intent(in) :: gravity(3)
    status = c_set_gravity(at(bodies), gravity)
  end function

  ! Coordinates and rows of one's own beside the bodies, once. NSDAE_E_ARGUMENT: the text names a
  ! callback that is missing, or that nothing calls; NSDAE_E_STATE.
  ! headers: wrappers nsdae_bodies_ set_user_rows

  ! Makes the system, or returns the first failure of any call before. The system keeps the model. A likely
  ! mistake is NSDAE_WARN_MODEL, with the system and its text in error.
  integer(c_int) function nsdae_bodies_system(bodies, system, error) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_system), intent(out) :: system
    type(nsdae_error), intent(out), optional :: error
    type(c_ptr) :: handle
    integer(c_int) :: note
    handle = c_null_ptr
    note = c_system(at(bodies), handle)
    status = note
    if (note >= 0) status = system_of(handle, system, error)
    if (note == NSDAE_OK .or. (note > 0 .and. status < 0)) return
    status = note
    if (present(error)) error = nsdae_bodies_error(bodies)
  end function

  ! headers: wrappers nsdae_bodies_ get_dims

  ! q [nq] and v [nv] at the start. NSDAE_E_ARGUMENT: the text of error has the sizes.
  integer(c_int) function nsdae_bodies_get_start(bodies, q, v, error) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    real(c_double), intent(inout), contiguous :: q(:), v(:)
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_dims) :: dims
    status = c_get_dims(at(bodies), dims)
    if (status < 0) return
    status = NSDAE_E_ARGUMENT
    if (size(q) < dims%nq .or. size(v) < dims%nv) then
      if (.not. present(error)) return
      error%status = status
      error%where = 'nsdae_bodies_get_start'
      error%argument = merge('q', 'v', size(q) < dims%nq)
      write (error%text, '(4(a, i0))') 'q has ', size(q), ' entries and v has ', size(v), ': they need at least ', dims%nq, &
        ' and ', dims%nv
      return
    end if
    status = c_get_start(at(bodies), q, v)
  end function

  ! Position in space of the point local in body axes, at the coordinates q [nq].
  integer(c_int) function nsdae_bodies_locate(bodies, q, body, local, point) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    real(c_double), intent(in), contiguous :: q(:)
    integer(c_int), intent(in) :: body
    real(c_double), intent(in) :: local(3)
    real(c_double), intent(inout) :: point(3)
    type(nsdae_dims) :: dims
    status = c_get_dims(at(bodies), dims)
    if (status < 0) return
    status = NSDAE_E_ARGUMENT
    if (size(q) < dims%nq) return
    status = c_locate(at(bodies), q, body, local, point)
  end function

  ! Reads a scene from a CSV file.
  integer(c_int) function nsdae_scene_read(path, scene, error) result(status)
    character(len=*), intent(in) :: path
    type(nsdae_scene), intent(out) :: scene
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    character(kind=c_char) :: c_path(len_trim(path) + 1)
    call to_chars(path, c_path)
    status = c_read(c_path, scene, why)
    call error_from_c(why, error)
  end function

  ! Adds gravity, floor, walls, bodies and their contacts to a spatial model.
  ! headers: wrappers nsdae_bodies_ add_scene

  ! Error record of the first call that failed.
  type(nsdae_error) function nsdae_bodies_error(bodies) result(error)
    type(nsdae_bodies), intent(in) :: bodies
    error = error_at(c_error(at(bodies)))
  end function

  ! Reads the triangles of an OBJ or STL file as a mesh; scale: metres in a unit of the file. length(3) is the caller's.
  integer(c_int) function nsdae_solid_read(path, scale, solid, error) result(status)
    character(len=*), intent(in) :: path
    real(c_double), intent(in) :: scale
    type(nsdae_solid), intent(out) :: solid
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_solid) :: read
    type(nsdae_c_error) :: why
    real(c_double), pointer :: point(:, :)
    integer(c_int), pointer :: triangle(:, :)
    integer :: lost
    character(kind=c_char) :: c_path(len_trim(path) + 1)
    call to_chars(path, c_path)
    status = c_solid_read(c_path, scale, read, why)
    call error_from_c(why, error)
    solid%shape = NSDAE_SHAPE_MESH
    if (status >= 0) then
      call c_f_pointer(read%point, point, [3, read%points])
      call c_f_pointer(read%triangle, triangle, [3, read%triangles])
      allocate (solid%point(3, read%points), solid%triangle(3, read%triangles), stat=lost)
      if (lost == 0) then
        solid%point = point
        solid%triangle = triangle
      else
        if (allocated(solid%point)) deallocate (solid%point)
        status = no_memory('nsdae_solid_read', error)
      end if
      call c_solid_release(read)
    end if
  end function

  ! Mass and inertia of a solid of uniform density, in its frame.
  integer(c_int) function nsdae_solid_inertia(solid, density, mass, inertia, error) result(status)
    type(nsdae_solid), intent(in), target :: solid
    real(c_double), intent(in) :: density
    real(c_double), intent(inout) :: mass, inertia(3)
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_inertia(to_c(solid), density, mass, inertia, why)
    call error_from_c(why, error)
  end function

  ! Surface of a polyhedron, mesh or height field: corners (3, 3 corners, triangles) in triangle, which has room for
  ! 2 points - 4 triangles, those of the mesh, two of each cell. Their number, or a status < 0.
  integer(c_int) function nsdae_solid_triangles(solid, triangle, error) result(number)
    type(nsdae_solid), intent(in), target :: solid
    real(c_double), intent(inout) :: triangle(3, 3, *)
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    number = c_triangles(to_c(solid), triangle, why)
    call error_from_c(why, error)
  end function

  ! A body of solids of uniform density: mass, inertia, and the frames about the centre of mass.
  integer(c_int) function nsdae_body_from_solids(solid, density, body, error) result(status)
    type(nsdae_solid), intent(inout), target :: solid(:)
    real(c_double), intent(in) :: density(:)
    type(nsdae_rigid_body), intent(inout) :: body
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    type(nsdae_c_solid) :: given(size(solid))
    integer :: i
    do i = 1, size(solid)
      given(i) = to_c(solid(i))
    end do
    status = c_from_solids(int(min(size(solid), size(density)), c_int), given, density, body, why)
    do i = 1, size(solid)
      solid(i)%position = given(i)%position
    end do
    call error_from_c(why, error)
  end function

  ! The corners stay where they are.
  type(nsdae_c_solid) function to_c(solid) result(to)
    type(nsdae_solid), intent(in), target :: solid
    to%shape = solid%shape
    to%radius = solid%radius
    to%length = solid%length
    if (solid%hollow) to%hollow = 1
    if (allocated(solid%triangle)) then
      if (size(solid%triangle, 1) == 3) then
        to%triangles = size(solid%triangle, 2, kind=c_int)
        to%triangle = c_loc(solid%triangle)
      end if
    end if
    if (allocated(solid%point)) then
      if (solid%shape == NSDAE_SHAPE_HEIGHT_FIELD) then
        to%grid = shape(solid%point, kind=c_int)
        to%point = c_loc(solid%point)
      else if (size(solid%point, 1) == merge(2, 3, solid%shape == NSDAE_SHAPE_POLYGON)) then
        to%points = size(solid%point, 2, kind=c_int)
        to%point = c_loc(solid%point)
      end if
    end if
    to%position = solid%position
    to%angle = solid%angle
    to%quaternion = solid%quaternion
    to%material = solid%material
    to%group = solid%group
    to%exclude = solid%exclude
  end function

end module
