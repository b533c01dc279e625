"""An export of one's own: a table with a row a touch, its part and its largest normal force."""

from tactiledata.export.base import ExportedFile, Exporter, count, no_counts


class TouchTableExporter(Exporter):
    """A CSV file of touches."""

    name = "touch_table"
    title = "a table of touches"
    lost = ("Pictures, and all values but the largest normal force.",)

    def files(self, episodes, plan):
        """One small file."""
        return [ExportedFile("touches.csv", 0, len(episodes), len(episodes.index.rows))]

    def write(self, episodes, file, path, advance):
        """The frames come in batches, so that memory stays flat."""
        noted, largest = no_counts(), {}
        for batch in episodes.batches(file.start, file.stop):
            count(noted, batch)
            force = batch.values["contact_wrench"][:, 2].max()
            largest[batch.episode] = max(force, largest.get(batch.episode, force))
            advance(len(batch))
        lines = ["trajectory,part,largest_fz_n"]
        lines += [f"{episodes.facts.uids[row]},{episodes.parts[row]},{force}" for row, force in largest.items()]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return noted

    def kept_as(self, stream, episodes):
        """Only one stream is kept."""
        return "largest_fz_n" if stream == "contact_wrench" else "not kept"

    def snippet(self, episodes, files):
        """Any reader of CSV files takes it."""
        return 'import pandas\n\nprint(pandas.read_csv("touches.csv"))'
