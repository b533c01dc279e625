"""The words, pages and documents of a diagnosis.

Results of the other rooms enter; sentences, `report.html`, `diagnosis.json` and `effects.json` leave. Nothing is fitted
or tested here. The page of a store begins with the causes that its zeros follow (words of `zeros.causes`), then says
what is missing (`sentences`) and what speaks against that (`unseen_page`); `naming_page` puts them in order. The page
of a table begins with the words of `formula.explain`. Read the modules in this order:

- `sentences`: what is missing, and with which numbers? (`Answer`)
- `diagnosis`: what does the diagnosis of a store hold, and what is its verdict?
- `glossary`: what do the terms on a page mean?
- `locator_rows`: how are the locators' results listed and drawn?
- `unseen_page`: how much better is the simulation on held-out data, in sentences and pictures?
- `other_steps`: how do E, nu and mu relate to those of other steps?
- `next_trial_words`: what should be recorded next?
- `naming_page`, `formula_page`: the pages of a store and of a table.
- `notes`: which trajectories, frames and effects took no part, and why?
- `earlier_files`: which files of an earlier diagnosis are removed from the folder?
- `documents`: the documents of both, and the files that are written.

This room may import every other room of the diagnosis; no other room may import it. `store.py` and `table.py` do.
"""
