! Triangulates four points of the plane with a point in their middle, and measures the Voronoi cells in a box.
!
! Build with: gfortran triangulate.f90 $(pkg-config --libs septet)
module septet
    use, intrinsic :: iso_c_binding
    implicit none

    ! The fields of septet_options in septet.h, in their order.
    type, bind(c) :: septet_options
        integer(c_size_t) :: size
        integer(c_int32_t) :: threads, skip_invalid
        integer(c_int64_t) :: seed, max_memory
        type(c_ptr) :: cancel, weights, period, origin
        integer(c_int32_t) :: wrap, reserved
    end type

    interface
        ! The function septet_options_init does not know all fields; this one sets as many as the size says.
        subroutine septet_options_init_sized(options, size) bind(c)
            import
            type(septet_options), intent(out) :: options
            integer(c_size_t), value :: size
        end subroutine

        integer(c_int32_t) function septet_triangulate(points, n, dimension, options, t) bind(c)
            import
            real(c_double), intent(in) :: points(*)
            integer(c_size_t), value :: n
            integer(c_int32_t), value :: dimension
            type(septet_options), intent(in) :: options
            type(c_ptr), intent(out) :: t
        end function

        integer(c_size_t) function septet_cells_count(t) bind(c)
            import
            type(c_ptr), value :: t
        end function

        integer(c_int32_t) function septet_cells_i64(t, cells) bind(c)
            import
            type(c_ptr), value :: t
            integer(c_int64_t), intent(out) :: cells(*)
        end function

        integer(c_int32_t) function septet_voronoi_volumes(t, low, high, threads, volumes) bind(c)
            import
            type(c_ptr), value :: t
            real(c_double), intent(in) :: low(*), high(*)
            integer(c_int32_t), value :: threads
            real(c_double), intent(out) :: volumes(*)
        end function

        subroutine septet_free(t) bind(c)
            import
            type(c_ptr), value :: t
        end subroutine
    end interface
end module

program triangulate
    use septet
    implicit none

    ! The coordinates of a point follow each other, as columns do in Fortran.
    real(c_double) :: points(2, 5) = reshape([0d0, 0d0, 2d0, 0d0, 2d0, 2d0, 0d0, 2d0, 1d0, 1d0], [2, 5])
    real(c_double) :: volumes(5)
    integer(c_int64_t), allocatable :: cells(:, :)
    type(septet_options) :: options
    type(c_ptr) :: t
    integer :: i

    call septet_options_init_sized(options, c_sizeof(options))
    options%threads = 2
    if (septet_triangulate(points, 5_c_size_t, 2_c_int32_t, options, t) /= 0) error stop 'triangulation'
    allocate (cells(3, septet_cells_count(t)))
    if (septet_cells_i64(t, cells) /= 0) error stop 'cells'
    do i = 1, size(cells, 2)
        print '(3i3)', cells(:, i)
    end do
    if (septet_voronoi_volumes(t, [0d0, 0d0], [2d0, 2d0], 1_c_int32_t, volumes) /= 0) error stop 'volumes'
    print '(5f6.2)', volumes
    call septet_free(t)
end program
