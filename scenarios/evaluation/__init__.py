"""Tables that compare methods: scenes drawn by each, judged alike, with intervals and pictures.

`entrants` lists the rows of each table, `evaluation` trains and draws what is missing in a folder,
`rows` judges the draws, `table`, `gallery` and `curves` write the results. Everything is kept as
soon as it is done, because by default each method of a table trains for an hour.
"""
