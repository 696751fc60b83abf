"""Threads that run a kernel together begin it together, and end it together whatever happens."""

import _thread
import threading
import time

import pytest

from granulab.contact.compiled.threads import Crew, rows_apart

N = 3


def test_each_thread_has_its_own_arguments_and_the_first_one_answers():
    seen = {}

    def kernel(k):
        seen[k] = threading.get_ident()
        return 10 * k

    assert Crew(N).run(kernel, [(1,), (2,), (3,)]) == 10
    assert sorted(seen) == [1, 2, 3]
    assert threading.get_ident() not in seen.values()  # which hears Ctrl-C


def test_all_are_in_the_kernel_at_once():
    """Otherwise those that wait in it for the others would do so for ever."""
    crew, meeting = Crew(N), threading.Barrier(N)
    for _ in range(20):
        crew.run(lambda: meeting.wait(timeout=10.0), [()] * N)


def test_an_interrupt_waits_until_the_kernels_have_ended():
    crew, ended = Crew(N), []

    def kernel(k):
        if k == 0:
            _thread.interrupt_main()
        time.sleep(0.2)
        ended.append(k)

    with pytest.raises(KeyboardInterrupt):
        crew.run(kernel, [(k,) for k in range(N)])
    assert sorted(ended) == [0, 1, 2]
    crew.run(lambda: None, [()] * N)  # and they are there for the next


def test_what_a_thread_raises_is_raised_where_it_was_called():
    def kernel(k):
        if k == 2:
            raise MemoryError

    with pytest.raises(MemoryError):
        Crew(N).run(kernel, [(k,) for k in range(N)])


@pytest.mark.parametrize(("n_rows", "n"), [(1, 1), (5, 2), (3, 17)])
def test_rows_of_threads_share_no_line_of_the_cache(n_rows, n):
    """Lines are of 64 bytes, which some processors load by twos."""
    rows = rows_apart(n_rows, n)
    assert rows.shape[0] == n_rows
    assert rows.shape[1] >= n
    assert all(row.ctypes.data % 128 == 0 for row in rows)
