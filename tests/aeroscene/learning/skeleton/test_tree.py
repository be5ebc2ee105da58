from __future__ import annotations

from aeroscene.learning.skeleton.tree import Tree
from tests.aeroscene.learning.skeleton.toy import CHAIR, CUP, HOUSE, ROOF, ROOM, TABLE, site


def test_depths_become_parents():
    tree = Tree(site())
    for depth, kind in ((1, HOUSE), (2, ROOM), (2, ROOF), (1, HOUSE)):
        tree.add(depth, kind, is_coarse=True)
    tree.turn_to(2)
    for depth, kind in ((1, TABLE), (2, CUP), (2, CUP), (1, CHAIR)):
        tree.add(depth, kind, is_coarse=False)
    skeleton = tree.skeleton()
    assert skeleton.parent.tolist() == [0, 0, 1, 1, 0, 2, 5, 5, 2]
    assert skeleton.n_coarse == 5


def test_a_tree_goes_on_from_the_coarse_part_of_a_skeleton():
    first = Tree(site())
    first.add(1, HOUSE, is_coarse=True)
    first.turn_to(1)
    first.add(1, CHAIR, is_coarse=False)
    again = Tree(first.skeleton()).skeleton()
    assert again.kind_id.tolist() == [1, HOUSE]
    assert again.n_coarse == 2
